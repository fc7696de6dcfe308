# unity: the unit test framework, fetched once into build/_unity and shared by all presets.
# Upstream at a pinned commit when its git host answers, else the very same three files out of
# Debian's source package ntpsec. -D FETCHCONTENT_SOURCE_DIR_UNITY=DIR takes a copy of your own.
include(FetchContent)

set(unity_url https://github.com/ThrowTheSwitch/Unity.git)
set(unity_commit b4b1994bd74f7ed9aaeb0233906294b7ba601fb3) # v2.5.1 and 20 commits
set(unity_dir ${PROJECT_SOURCE_DIR}/build/_unity)

function(cam_unity_is_genuine dir result)
    set(${result} TRUE PARENT_SCOPE)
    foreach(pair IN ITEMS # of unity_commit
            unity.c:2e3a0610268455520a5796345b503d00c34a47fe97ed3750349cbd4b2b1990f3
            unity.h:681ac98a63ac11effb11e59d580f6ca82abca1bd34069465c38e3b15344256c0
            unity_internals.h:adfd612c217e59468c5ebe978640e77e5f539e820ffc0c195a98c5a36f0ac868)
        string(REPLACE ":" ";" pair ${pair})
        list(GET pair 0 name)
        list(GET pair 1 expected)
        set(actual missing)
        if(EXISTS ${dir}/src/${name})
            file(SHA256 ${dir}/src/${name} actual)
        endif()
        if(NOT actual STREQUAL expected)
            set(${result} FALSE PARENT_SCOPE)
        endif()
    endforeach()
endfunction()

function(cam_unity_fetch)
    set(ENV{GIT_TERMINAL_PROMPT} 0)
    execute_process(COMMAND git ls-remote --exit-code ${unity_url} HEAD
        TIMEOUT 6 RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
    file(REMOVE_RECURSE ${unity_dir}) # what an interrupted fetch left
    if(status EQUAL 0)
        message(STATUS "Unity: from ${unity_url}")
        # Populate only: SOURCE_SUBDIR names no folder, so Unity's own CMakeLists.txt stays out.
        FetchContent_Declare(unity GIT_REPOSITORY ${unity_url} GIT_TAG ${unity_commit}
            SOURCE_DIR ${unity_dir} SOURCE_SUBDIR none)
        FetchContent_MakeAvailable(unity)
    else()
        message(STATUS "Unity: the git host does not answer, taking Debian's source package ntpsec")
        execute_process(COMMAND bash ${PROJECT_SOURCE_DIR}/tools/cmake/unity_from_debian.sh ${unity_dir}
            RESULT_VARIABLE status)
        if(NOT status EQUAL 0)
            message(FATAL_ERROR "Unity: neither ${unity_url} nor Debian's source package ntpsec can be "
                "had. Clone commit ${unity_commit} elsewhere and configure with "
                "-D FETCHCONTENT_SOURCE_DIR_UNITY=DIR")
        endif()
    endif()
    cam_unity_is_genuine(${unity_dir} genuine)
    if(NOT genuine)
        file(REMOVE_RECURSE ${unity_dir})
        message(FATAL_ERROR "Unity: what was fetched is not commit ${unity_commit}")
    endif()
endfunction()

if(FETCHCONTENT_SOURCE_DIR_UNITY)
    set(unity_dir ${FETCHCONTENT_SOURCE_DIR_UNITY})
else()
    file(LOCK ${PROJECT_SOURCE_DIR}/build/_unity.lock GUARD FILE TIMEOUT 300)
    cam_unity_is_genuine(${unity_dir} genuine)
    if(NOT genuine)
        cam_unity_fetch()
    endif()
    file(LOCK ${PROJECT_SOURCE_DIR}/build/_unity.lock RELEASE)
endif()

add_library(unity STATIC ${unity_dir}/src/unity.c)
if(CMAKE_CROSSCOMPILING) # images do not tell where it was taken from
    target_compile_options(unity PUBLIC -ffile-prefix-map=${unity_dir}=unity)
endif()
target_include_directories(unity SYSTEM PUBLIC ${unity_dir}/src)
target_compile_definitions(unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)
