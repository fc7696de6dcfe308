# SPDX-License-Identifier: Apache-2.0
# Common to the emulated MPS2 boards. Set before: board_cpu (core options), board_machine (QEMU machine),
# board_psram (address of the heap).
# Enumerations have the width of the host's, so that structures are those of the host's tests. Those
# of newlib differ, but no call passes one.
add_compile_options(${board_cpu} -mthumb -ffunction-sections -fdata-sections -fno-short-enums)
add_link_options(${board_cpu} -mthumb -nostartfiles -Wl,--no-enum-size-warning)

add_library(board OBJECT
    ${CMAKE_CURRENT_LIST_DIR}/mps2_start.c ${CMAKE_CURRENT_LIST_DIR}/mps2_semihost.c
    ${CMAKE_CURRENT_LIST_DIR}/mps2_libc.c)
target_include_directories(board PUBLIC ${CMAKE_CURRENT_LIST_DIR})
target_compile_options(board PRIVATE -Wall -Wextra -Wconversion -Wshadow -Werror)
target_link_options(board INTERFACE
    -T${CMAKE_CURRENT_LIST_DIR}/mps2.ld -Wl,--defsym=mps2_psram=${board_psram} -Wl,--gc-sections
    -Wl,--no-warn-rwx-segments)
set_target_properties(board PROPERTIES INTERFACE_LINK_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/mps2.ld)

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-system-arm -M ${board_machine} -nographic -monitor none
    -serial none -semihosting-config enable=on,target=native -kernel)
