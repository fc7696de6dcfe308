# SPDX-License-Identifier: Apache-2.0
# Writes what a run has measured as JSON: instructions of a tick without and with the plan, their
# mean in the cut, bytes of stack.
# Prints the change of each against tests/bench/figures.json.
# usage: cmake -D MEASURED=test_budget.txt -D STACK=interrupt.txt -D OUTPUT=figures.json
#              -D RECORDED=tests/bench/figures.json -D CORE=m7 -P figures.cmake
cmake_minimum_required(VERSION 3.25)

file(STRINGS ${STACK} stack REGEX "^isr-stack [0-9]+ bytes")
if(NOT stack MATCHES "^isr-stack ([0-9]+) bytes")
    message(FATAL_ERROR "${STACK}: no line \"isr-stack N bytes\"")
endif()
string(JSON json SET "{}" stack_bytes ${CMAKE_MATCH_1})

file(STRINGS ${MEASURED} figures REGEX "^figure [a-z_]+ [0-9]+")
foreach(figure IN LISTS figures)
    string(REGEX MATCH "^figure ([a-z_]+) ([0-9]+)" matched "${figure}")
    string(JSON json SET "${json}" "${CMAKE_MATCH_1}" "${CMAKE_MATCH_2}")
endforeach()
foreach(name tick_cut_max tick_max plan_tick_max mean)
    string(JSON value ERROR_VARIABLE missing GET "${json}" ${name})
    if(missing)
        message(FATAL_ERROR "${MEASURED}: no figure ${name}")
    endif()
endforeach()

set(states "{}")
set(line "^([a-z0-9 ]+[a-z0-9]) +(tick|plan) +([a-z]+) +([0-9]+) [.][.] +([0-9]+), mean +([0-9]+) instructions, ([0-9]+) ticks")
file(STRINGS ${MEASURED} counted REGEX "${line}")
foreach(one IN LISTS counted)
    string(REGEX MATCH "${line}" matched "${one}")
    set(key "${CMAKE_MATCH_1}, ${CMAKE_MATCH_3}, ${CMAKE_MATCH_2}")
    string(JSON states SET "${states}" "${key}"
        "{\"min\": ${CMAKE_MATCH_4}, \"max\": ${CMAKE_MATCH_5}, \"mean\": ${CMAKE_MATCH_6}, \"ticks\": ${CMAKE_MATCH_7}}")
endforeach()
string(JSON json SET "${json}" sessions "${states}")

file(WRITE ${OUTPUT} "${json}\n")
message("${json}")

# What changed against the record, for the reviewer.
file(READ ${RECORDED} recorded)
foreach(name tick_cut_max tick_max plan_tick_max mean stack_bytes)
    string(JSON now GET "${json}" ${name})
    string(JSON before ERROR_VARIABLE missing GET "${recorded}" "${CORE}.${name}")
    if(missing)
        message("${name}: ${now}, not recorded before")
    else()
        string(REGEX REPLACE "[.].*" "" before "${before}")
        math(EXPR change "${now} - ${before}")
        message("${name}: ${now}, ${change} against the record")
    endif()
endforeach()
