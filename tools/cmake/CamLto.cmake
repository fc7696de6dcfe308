# Link-time optimisation: the HAL is chosen at link time, and only LTO can inline its calls into the
# tick.
#
# Most programs are tests, and LTO would compile firmware and ports once more for each of them.
# Firmware, ports and simulator are therefore compiled for both ways (cam_lto_objects), and a program
# that is to be fast, or like a flashed image, says so (cam_lto_link). On the host gcc does it; of
# clang, whose objects are for one way only, the host wants warnings and an analysis.
if(CMAKE_CROSSCOMPILING)
    set(cam_has_lto ${CAM_BOARD})
elseif(CMAKE_BUILD_TYPE STREQUAL "Release" AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
    include(CheckIPOSupported)
    check_ipo_supported(RESULT cam_has_lto OUTPUT cam_lto_output LANGUAGES C)
    if(NOT cam_has_lto)
        message(STATUS "No link-time optimisation with this tool chain; HAL calls stay calls")
    endif()
endif()

if(cam_has_lto) # objects hold both, and the linker would take the slow one
    add_link_options($<$<NOT:$<BOOL:$<TARGET_PROPERTY:CAM_LTO>>>:-fno-lto>)
endif()

function(cam_lto_objects target)
    if(cam_has_lto)
        target_compile_options(${target} PRIVATE -flto -ffat-lto-objects)
    endif()
endfunction()

function(cam_lto_link target)
    if(cam_has_lto)
        set_target_properties(${target} PROPERTIES CAM_LTO TRUE)
        target_link_options(${target} PRIVATE -flto=auto -O2)
    endif()
endfunction()
