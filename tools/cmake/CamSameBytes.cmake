# The same sources give the same image, wherever they and the build folder lie.
if(CMAKE_CROSSCOMPILING)
    set(cam_same_bytes
        -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=
        -ffile-prefix-map=${PROJECT_BINARY_DIR}=build)
    add_compile_options(${cam_same_bytes})
    add_link_options(${cam_same_bytes}) # where link-time optimisation compiles
endif()
