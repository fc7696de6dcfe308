# gpiod: libgpiod, and which of the two APIs it has in GPIOD_API (1 or 2).
#
# CAM_GPIOD=system  what pkg-config finds: 1.6 or 2.x
# CAM_GPIOD=fetch   version 2 out of the Python package gpiod, whose source holds the C library: for
#                   systems that carry 1.6 only
include_guard(GLOBAL)
set(CAM_GPIOD system CACHE STRING "Where libgpiod comes from: system or fetch")
set_property(CACHE CAM_GPIOD PROPERTY STRINGS system fetch)

set(gpiod_version 2.5.0) # of the Python package: C library 2.3
set(gpiod_sha256 53ae5a1f14d6388c155b591ca0fc0cfa73b44d4f6d8d117e8a9e68f5902d187a)

function(cam_gpiod_fetch dir)
    find_program(CAM_PYTHON NAMES python3 HINTS ${PROJECT_SOURCE_DIR}/build/venv/bin NO_DEFAULT_PATH)
    find_program(CAM_PYTHON NAMES python3 REQUIRED)
    file(MAKE_DIRECTORY ${dir})
    file(WRITE ${dir}/requirement.txt "gpiod==${gpiod_version} --hash=sha256:${gpiod_sha256}\n")
    message(STATUS "libgpiod: from the Python package gpiod ${gpiod_version}")
    execute_process(
        COMMAND ${CAM_PYTHON} -m pip download -q --disable-pip-version-check --no-input --no-deps
            --no-binary :all: --require-hashes -r ${dir}/requirement.txt -d ${dir}
        RESULT_VARIABLE status)
    if(NOT status EQUAL 0)
        message(FATAL_ERROR "libgpiod: pip could not get gpiod ${gpiod_version}. Configure with "
            "-D CAM_GPIOD=system and apt install libgpiod-dev, or put gpiod-${gpiod_version}.tar.gz into ${dir}")
    endif()
endfunction()

function(cam_gpiod_build)
    set(dir ${PROJECT_SOURCE_DIR}/build/_gpiod)
    set(archive ${dir}/gpiod-${gpiod_version}.tar.gz)
    file(LOCK ${PROJECT_SOURCE_DIR}/build/_gpiod.lock GUARD FUNCTION TIMEOUT 300)
    if(NOT EXISTS ${archive})
        cam_gpiod_fetch(${dir})
    endif()
    file(SHA256 ${archive} actual)
    if(NOT actual STREQUAL gpiod_sha256)
        message(FATAL_ERROR "libgpiod: ${archive} is not gpiod ${gpiod_version}; remove it")
    endif()
    file(ARCHIVE_EXTRACT INPUT ${archive} DESTINATION ${dir})
    file(STRINGS ${dir}/gpiod-${gpiod_version}/libgpiod-version.txt version LIMIT_COUNT 1)
    file(GLOB sources ${dir}/gpiod-${gpiod_version}/lib/*.c)
    add_library(gpiod STATIC ${sources})
    target_include_directories(gpiod SYSTEM PUBLIC ${dir}/gpiod-${gpiod_version}/include
        PRIVATE ${dir}/gpiod-${gpiod_version}/lib)
    target_compile_definitions(gpiod PRIVATE _GNU_SOURCE GPIOD_VERSION_STR="${version}"
        GPIOD_API_VERSION_STR="${version}")
    set_target_properties(gpiod PROPERTIES C_EXTENSIONS ON)
endfunction()

if(CAM_GPIOD STREQUAL "fetch")
    cam_gpiod_build()
    set(GPIOD_API 2)
else()
    include(HostPackages)
    cam_host_package(gpiod libgpiod libgpiod-dev)
    if(gpiod_VERSION VERSION_GREATER_EQUAL 2)
        set(GPIOD_API 2)
    else()
        set(GPIOD_API 1)
    endif()
endif()
message(STATUS "libgpiod: API ${GPIOD_API}")
