# Link-time optimisation in release builds: the HAL is chosen at link time, and only LTO can
# inline its calls into the tick.
if(CMAKE_BUILD_TYPE STREQUAL "Release")
    include(CheckIPOSupported)
    check_ipo_supported(RESULT cam_has_lto OUTPUT cam_lto_output LANGUAGES C)
    if(cam_has_lto)
        set(CMAKE_INTERPROCEDURAL_OPTIMIZATION ON)
    else()
        message(STATUS "No link-time optimisation with this tool chain; HAL calls stay calls")
    endif()
endif()
