# monocypher: keyed BLAKE2b, comparison in constant time and the curve of Ed25519, fetched once into
# build/_monocypher and shared by all presets. Its SHA-512 lies in a file of its own, which the
# source of the Python package pymonocypher leaves out; firmware/signature/cam_sha512.c takes its place.
#
# It is pinned twice: the archive by its SHA-256, and so are the two files in build/_monocypher, which
# any other way of putting them there has to meet, too. -D CAM_MONOCYPHER=DIR takes a copy of your own
# of these files. Makefiles of other build systems ask for the files by
# cmake -P tools/cmake/Monocypher.cmake.
if(CMAKE_SCRIPT_MODE_FILE)
    get_filename_component(monocypher_root ${CMAKE_CURRENT_LIST_DIR}/../.. ABSOLUTE)
else()
    set(monocypher_root ${PROJECT_SOURCE_DIR})
endif()
set(CAM_MONOCYPHER "" CACHE PATH "Folder with monocypher.c and monocypher.h; empty: they are fetched")

set(monocypher_version 4.0.3.4) # of the Python package: C library 4.0.3
set(monocypher_sha256 5e56e3d3eb770a53e0b9f6274146663c11a11f3d0de5cd48e3be0428d1b07a4a)
set(monocypher_dir ${monocypher_root}/build/_monocypher)

function(cam_monocypher_is_genuine dir result)
    set(${result} TRUE PARENT_SCOPE)
    foreach(pair IN ITEMS
            monocypher.c:57eb914fc88136119bd41655cccb8c250048bf54d470540625186f8ab16f64be
            monocypher.h:c494da712122da7ff679fdcf318a5317e84972b6c950fe9d896212947797facd)
        string(REPLACE ":" ";" pair ${pair})
        list(GET pair 0 name)
        list(GET pair 1 expected)
        set(actual missing)
        if(EXISTS ${dir}/${name})
            file(SHA256 ${dir}/${name} actual)
        endif()
        if(NOT actual STREQUAL expected)
            set(${result} FALSE PARENT_SCOPE)
        endif()
    endforeach()
endfunction()

function(cam_monocypher_fetch)
    find_program(CAM_PYTHON NAMES python3 HINTS ${monocypher_root}/build/venv/bin NO_DEFAULT_PATH)
    find_program(CAM_PYTHON NAMES ${Python_EXECUTABLE} python3 REQUIRED) # the first is that of a wheel
    set(dir ${monocypher_dir}.part)
    set(package pymonocypher-${monocypher_version})
    file(REMOVE_RECURSE ${dir}) # what an interrupted fetch left
    file(MAKE_DIRECTORY ${dir})
    file(WRITE ${dir}/requirement.txt
        "pymonocypher==${monocypher_version} --hash=sha256:${monocypher_sha256}\n")
    message(STATUS "Monocypher: from the Python package pymonocypher ${monocypher_version}")
    foreach(isolation IN ITEMS --no-build-isolation "") # the first is quicker by far
        execute_process(
            COMMAND ${CAM_PYTHON} -m pip download -q --disable-pip-version-check --no-input --no-deps
                --no-binary pymonocypher --require-hashes -r ${dir}/requirement.txt -d ${dir} ${isolation}
            RESULT_VARIABLE status ERROR_VARIABLE said)
        if(status EQUAL 0)
            break()
        endif()
    endforeach()
    if(NOT status EQUAL 0)
        message(FATAL_ERROR "${said}\nMonocypher: ${CAM_PYTHON} -m pip could not get pymonocypher ${monocypher_version}. Install python3-pip, "
            "or put monocypher.c and monocypher.h of Monocypher 4.0.3 into ${monocypher_dir}, or configure "
            "with -D CAM_MONOCYPHER=DIR")
    endif()
    file(ARCHIVE_EXTRACT INPUT ${dir}/${package}.tar.gz DESTINATION ${dir})
    file(REMOVE_RECURSE ${monocypher_dir})
    file(MAKE_DIRECTORY ${monocypher_dir})
    foreach(name IN ITEMS monocypher.c monocypher.h LICENSE.txt)
        file(COPY ${dir}/${package}/${name} DESTINATION ${monocypher_dir})
    endforeach()
    file(REMOVE_RECURSE ${dir})
endfunction()

if(CAM_MONOCYPHER)
    set(monocypher_dir ${CAM_MONOCYPHER})
else()
    file(LOCK ${monocypher_root}/build/_monocypher.lock GUARD PROCESS TIMEOUT 300)
    cam_monocypher_is_genuine(${monocypher_dir} genuine)
    if(NOT genuine)
        cam_monocypher_fetch()
    endif()
    file(LOCK ${monocypher_root}/build/_monocypher.lock RELEASE)
endif()
cam_monocypher_is_genuine(${monocypher_dir} genuine)
if(NOT genuine)
    message(FATAL_ERROR "Monocypher: ${monocypher_dir} does not hold monocypher.c and monocypher.h of "
        "Monocypher 4.0.3; remove it, and it is fetched again")
endif()

if(NOT CMAKE_SCRIPT_MODE_FILE)
    add_library(monocypher STATIC ${monocypher_dir}/monocypher.c)
    target_include_directories(monocypher SYSTEM PUBLIC ${monocypher_dir})
    # Small, and it does not tell where it was taken from.
    target_compile_options(monocypher PRIVATE -Os -ffile-prefix-map=${monocypher_dir}=monocypher)
    target_compile_definitions(monocypher PRIVATE BLAKE2_NO_UNROLLING)
endif()
