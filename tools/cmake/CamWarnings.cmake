# cam_warnings: what every target of ours is compiled with; fetched code is not.
add_library(cam_warnings INTERFACE)
target_compile_options(cam_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wstrict-prototypes -Wundef -Werror)
if(CMAKE_C_COMPILER_ID STREQUAL "Clang" AND CMAKE_C_COMPILER_VERSION VERSION_GREATER_EQUAL 19)
    # A constant of an enumeration is an integer like any other, exact as a double.
    target_compile_options(cam_warnings INTERFACE -Wno-enum-float-conversion)
endif()
