# SPDX-License-Identifier: Apache-2.0
# Runs a program that must end with a certain exit status and say a certain text.
# usage: cmake -D STATUS=N -D TEXT=... -P expect_status.cmake -- COMMAND...
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/../after_dashes.cmake)

execute_process(COMMAND ${command} RESULT_VARIABLE status OUTPUT_VARIABLE output)
message("${output}")
if(NOT status STREQUAL STATUS)
    message(FATAL_ERROR "exit status ${status}, expected ${STATUS}")
endif()
string(FIND "${output}" "${TEXT}" place)
if(place EQUAL -1)
    message(FATAL_ERROR "\"${TEXT}\" is missing")
endif()
