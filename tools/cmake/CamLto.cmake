# Link-time optimisation of the images for boards: the HAL is chosen at link time, and only LTO can
# inline its calls into the tick. On a host it gains the simulator less than a twentieth and would
# double the time of the build.
#
# Most programs of a board are tests, and LTO would compile firmware and ports once more for each of
# them. Firmware and ports are therefore compiled for both ways (cam_lto_objects), and a program that
# is like a flashed image says so (cam_lto_link).
if(CAM_BOARD) # objects hold both, and the linker would take the slow one
    add_link_options($<$<NOT:$<BOOL:$<TARGET_PROPERTY:CAM_LTO>>>:-fno-lto>)
endif()

function(cam_lto_objects target)
    if(CAM_BOARD)
        target_compile_options(${target} PRIVATE -flto -ffat-lto-objects)
    endif()
endfunction()

function(cam_lto_link target)
    if(CAM_BOARD)
        set_target_properties(${target} PROPERTIES CAM_LTO TRUE)
        target_link_options(${target} PRIVATE -flto=auto -O2)
    endif()
endfunction()
