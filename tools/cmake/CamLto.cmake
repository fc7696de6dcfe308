# Link-time optimisation in release builds: the HAL is chosen at link time, and only LTO can
# inline its calls into the tick.
#
# Programs of the emulated boards are many and mostly tests: there the firmware and its ports are
# compiled for both ways (cam_lto_objects), and a program that is to be like a flashed image says so
# (cam_lto_link). CMake's own check cannot link for them.
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT CMAKE_CROSSCOMPILING)
    include(CheckIPOSupported)
    check_ipo_supported(RESULT cam_has_lto OUTPUT cam_lto_output LANGUAGES C)
    if(cam_has_lto)
        set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
    else()
        message(STATUS "No link-time optimisation with this tool chain; HAL calls stay calls")
    endif()
endif()

function(cam_lto_objects target)
    if(CAM_BOARD)
        target_compile_options(${target} PRIVATE -flto -ffat-lto-objects)
    endif()
endfunction()

function(cam_lto_link target)
    set_target_properties(${target} PROPERTIES CAM_LTO TRUE)
    target_link_options(${target} PRIVATE -flto=auto -O2)
endfunction()
