# cam_warnings: what every target of ours is compiled with; fetched code is not.
add_library(cam_warnings INTERFACE)
target_compile_options(cam_warnings INTERFACE
    -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wstrict-prototypes -Wundef -Werror)
