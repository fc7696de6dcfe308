# SPDX-License-Identifier: Apache-2.0
# Fails when the marks between the stages change the tick: by session and state, the sums of
# test_stages must be the whole ticks of test_budget, give or take a few instructions.
# usage: cmake -D WHOLE=FILE -D STAGES=FILE -P stages_agree.cmake
cmake_minimum_required(VERSION 3.25)

set(tolerance 3) # the marks keep other registers busy; today it is 1

set(line "(uniform|modulated|faults) +([a-z]+) +([0-9]+) [.][.] +([0-9]+) instructions, ([0-9]+) ticks")
file(STRINGS ${STAGES} sums REGEX "^${line}")
file(STRINGS ${WHOLE} wholes REGEX "^${line}")
list(LENGTH sums n_sums)
list(LENGTH wholes n_wholes)
if(n_sums EQUAL 0 OR NOT n_sums EQUAL n_wholes)
    message(FATAL_ERROR "${n_sums} states with stages, ${n_wholes} without")
endif()

set(most 0)
set(findings "")
foreach(sum whole IN ZIP_LISTS sums wholes)
    string(REGEX MATCH "${line}" matched "${sum}")
    set(of_sum "${CMAKE_MATCH_1} ${CMAKE_MATCH_2} ${CMAKE_MATCH_5}")
    set(sum_min ${CMAKE_MATCH_3})
    set(sum_max ${CMAKE_MATCH_4})
    string(REGEX MATCH "${line}" matched "${whole}")
    if(NOT of_sum STREQUAL "${CMAKE_MATCH_1} ${CMAKE_MATCH_2} ${CMAKE_MATCH_5}")
        list(APPEND findings "other ticks\n  ${sum}\n  ${whole}")
        continue()
    endif()
    math(EXPR off_min "${sum_min} - ${CMAKE_MATCH_3}")
    math(EXPR off_max "${sum_max} - ${CMAKE_MATCH_4}")
    foreach(off ${off_min} ${off_max})
        string(REPLACE "-" "" off "${off}")
        if(off GREATER tolerance)
            list(APPEND findings "${off} instructions apart\n  ${sum}\n  ${whole}")
        endif()
        if(off GREATER most)
            set(most ${off})
        endif()
    endforeach()
endforeach()

if(findings)
    list(JOIN findings "\n" findings)
    message(FATAL_ERROR "stages and whole tick:\n${findings}")
endif()
message("${n_sums} states, sums of the stages at most ${most} instructions off the whole tick")
