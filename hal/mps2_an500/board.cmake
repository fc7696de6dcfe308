# SPDX-License-Identifier: Apache-2.0
# Cortex-M7 with double-precision unit.
set(board_cpu -mcpu=cortex-m7 -mfpu=fpv5-d16 -mfloat-abi=hard)
set(board_machine mps2-an500)
set(board_psram 0x60000000)
include(${CMAKE_CURRENT_LIST_DIR}/../mps2/mps2.cmake)
