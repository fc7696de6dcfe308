# cjson, inih: libraries of the system that the simulator reads and writes its files with.
find_package(PkgConfig REQUIRED)

function(cam_host_package target module apt_package)
    pkg_check_modules(${target} IMPORTED_TARGET ${module})
    if(NOT ${target}_FOUND)
        message(FATAL_ERROR "${module} is missing. On Debian or Ubuntu: apt install ${apt_package}")
    endif()
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE PkgConfig::${target})
endfunction()

cam_host_package(cjson libcjson libcjson-dev)
cam_host_package(inih inih libinih-dev)
