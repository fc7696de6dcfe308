# SPDX-License-Identifier: Apache-2.0
# The rooms of firmware/ from the bottom to the top: those that the interrupt runs, then the slow side.
set(CAM_INTERRUPT_ROOMS base servo table motion record plan tick)
set(CAM_SLOW_ROOMS doubles param feasible build learning recorder machine remote)
list(TRANSFORM CAM_INTERRUPT_ROOMS PREPEND cam_ OUTPUT_VARIABLE CAM_INTERRUPT_TARGETS)
list(TRANSFORM CAM_SLOW_ROOMS PREPEND cam_ OUTPUT_VARIABLE CAM_SLOW_TARGETS)
