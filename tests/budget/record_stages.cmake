# SPDX-License-Identifier: Apache-2.0
# Runs test_stages and writes what it measured as the limits of the board, whether the old ones held
# or not.
# usage: cmake -D "RUN=PROGRAM;ARGUMENT;..." -D LIMITS=FILE -P record_stages.cmake
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND ${RUN} OUTPUT_VARIABLE text ERROR_VARIABLE text)
string(REGEX MATCHALL "record #define [^\n]*" lines "${text}")
list(LENGTH lines n_lines)
if(NOT n_lines EQUAL 3)
    message(FATAL_ERROR "recorded ${n_lines} sessions of 3:\n${text}")
endif()
list(JOIN lines "\n" lines)
string(REPLACE "record " "" lines "${lines}")

file(WRITE ${LIMITS}
"// SPDX-License-Identifier: Apache-2.0
/// Most instructions of sense, angle, play, guard, actuate, publish, by session; written by the
/// target record_stages (test_stages.c).
#ifndef STAGES_LIMITS_H
#define STAGES_LIMITS_H

${lines}

#endif
")
message("${lines}")
