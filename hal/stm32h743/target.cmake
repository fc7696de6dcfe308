# SPDX-License-Identifier: Apache-2.0
# Options of everything linked into the image. The slow side uses the floating-point unit.
set(core -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard)
add_compile_options(${core} -ffunction-sections -fdata-sections
    -fno-tree-loop-distribute-patterns -fstack-usage)
add_link_options(${core})

# CMake's test of link-time optimisation needs an image that links without start-up code.
if(CMAKE_BUILD_TYPE STREQUAL "Release")
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
endif()
