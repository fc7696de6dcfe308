# SPDX-License-Identifier: Apache-2.0
# Options of everything linked into the image. No floating point: the FPU stays off, and a
# floating-point instruction is a usage fault.
add_compile_options(-mcpu=cortex-m7 -mthumb -mfloat-abi=soft -ffunction-sections -fdata-sections
    -fno-tree-loop-distribute-patterns -fstack-usage)
add_link_options(-mcpu=cortex-m7 -mthumb -mfloat-abi=soft)

# CMake's test of link-time optimisation needs an image that links without start-up code.
if(CMAKE_BUILD_TYPE STREQUAL "Release")
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
endif()
