# SPDX-License-Identifier: Apache-2.0
# Runs a program and keeps its output in a file too; fails as the program does.
# usage: cmake -D OUTPUT=FILE -P run_kept.cmake -- PROGRAM [ARGUMENT...]
cmake_minimum_required(VERSION 3.25)

file(REMOVE ${OUTPUT}) # of an earlier run
include(${CMAKE_CURRENT_LIST_DIR}/../after_dashes.cmake)

execute_process(COMMAND ${command}
    OUTPUT_VARIABLE text ERROR_VARIABLE text ECHO_OUTPUT_VARIABLE ECHO_ERROR_VARIABLE
    RESULT_VARIABLE status)
if(NOT status EQUAL 0)
    message(FATAL_ERROR "exit status ${status}")
endif()
file(WRITE ${OUTPUT} "${text}")
