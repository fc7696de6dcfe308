# Fails when the firmware uses a heap, or the rooms of the interrupt floating point, or when it
# includes more than the contract.
# usage: cmake -D FIRMWARE_DIR=... -P firmware_lint.cmake
cmake_minimum_required(VERSION 3.25)

# What a C11 compiler without an operating system brings, plus memcpy() and its kin.
set(system_headers stdint stdbool stddef stdatomic stdalign stdnoreturn limits inttypes string)
# The contract, and what is generated from camturn.dbc.
set(foreign_headers hal/hal.h hal/version.h camturn.h)
set(forbidden_words float malloc calloc realloc free)
include(${CMAKE_CURRENT_LIST_DIR}/FirmwareRooms.cmake) # CAM_INTERRUPT_ROOMS

set(findings "")
file(GLOB_RECURSE files ${FIRMWARE_DIR}/*.c ${FIRMWARE_DIR}/*.h)
list(FILTER files EXCLUDE REGEX /remote/can/) # generated
set(own_headers "")
foreach(file IN LISTS files)
    cmake_path(GET file FILENAME name)
    list(APPEND own_headers ${name}) # which of them a room sees is up to its include path
endforeach()
foreach(file IN LISTS files)
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${FIRMWARE_DIR} OUTPUT_VARIABLE name)
    file(READ ${file} code)
    # CMake takes ; and [ ] for list syntax when it walks over matches.
    string(REGEX REPLACE "[][;]" " " code "${code}")
    string(REGEX REPLACE "/\\*([^*]|\\*+[^*/])*\\*+/|//[^\n]*" "" code "${code}")

    string(REGEX MATCHALL "#[ \t]*include[ \t]*[<\"][^>\"\n]*" includes "${code}")
    foreach(include IN LISTS includes)
        string(REGEX REPLACE "#[ \t]*include[ \t]*" "" include "${include}")
        if(include MATCHES "^<(.*)\\.h$")
            if(NOT CMAKE_MATCH_1 IN_LIST system_headers)
                list(APPEND findings "${name}: <${CMAKE_MATCH_1}.h> is not for the firmware")
            endif()
        elseif(include MATCHES "^\"(.*)$" AND NOT CMAKE_MATCH_1 IN_LIST foreign_headers
               AND NOT CMAKE_MATCH_1 IN_LIST own_headers)
            list(APPEND findings "${name}: \"${CMAKE_MATCH_1}\" is neither firmware nor one of ${foreign_headers}")
        endif()
    endforeach()

    string(REGEX REPLACE "\"([^\"\\\n]|\\\\.)*\"" "\"\"" code "${code}")
    cmake_path(GET name PARENT_PATH room)
    set(words ${forbidden_words})
    if(room IN_LIST CAM_INTERRUPT_ROOMS)
        list(APPEND words double cam_doubles)
    endif()
    foreach(word IN LISTS words)
        if(code MATCHES "(^|[^A-Za-z0-9_])${word}([^A-Za-z0-9_]|$)")
            list(APPEND findings "${name}: '${word}' is not for the firmware")
        endif()
    endforeach()
endforeach()

if(findings)
    list(JOIN findings "\n  " findings)
    message(FATAL_ERROR "Firmware lint:\n  ${findings}")
endif()
list(LENGTH files n_files)
message(STATUS "Firmware lint: ${n_files} files clean")
