# The same sources give the same image, wherever they and the build folder lie.
if(CMAKE_CROSSCOMPILING)
    add_compile_options(
        -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=
        -ffile-prefix-map=${PROJECT_BINARY_DIR}=build)
endif()
