# SPDX-License-Identifier: Apache-2.0
# Cortex-M4 with single-precision unit.
set(board_cpu -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard)
set(board_machine mps2-an386)
set(board_psram 0x21000000)
include(${CMAKE_CURRENT_LIST_DIR}/../mps2/mps2.cmake)
