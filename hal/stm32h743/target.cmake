# SPDX-License-Identifier: Apache-2.0
# Options of everything that is linked into the image. No floating point: the unit stays off, and
# an instruction that needs it is a usage fault.
add_compile_options(-mcpu=cortex-m7 -mthumb -mfloat-abi=soft -ffunction-sections -fdata-sections
    -fno-tree-loop-distribute-patterns -fstack-usage)
add_link_options(-mcpu=cortex-m7 -mthumb -mfloat-abi=soft)

# CMake's own test of link-time optimisation wants an image that links without a start-up.
if(CMAKE_BUILD_TYPE STREQUAL "Release")
    set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
endif()
