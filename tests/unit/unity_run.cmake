# SPDX-License-Identifier: Apache-2.0
# Writes RUN, which includes the C file SOURCE and defines test_NAME_run(): it runs each
# `static void test_X(void)` of the file, in their order, with the file's own setUp and tearDown.
file(STRINGS ${SOURCE} lines REGEX "^static void test_[A-Za-z0-9_]+\\(void\\)$")
set(calls "")
foreach(line IN LISTS lines)
    string(REGEX REPLACE "^static void (.*)\\(void\\)$" "\\1" test "${line}")
    string(APPEND calls "    UnityDefaultTestRun(${test}, \"${test}\", 0);\n")
endforeach()
cmake_path(GET SOURCE STEM name)
# By its place in the project, so that the program has the same bytes wherever that lies.
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH tests)
cmake_path(GET tests PARENT_PATH root)
cmake_path(RELATIVE_PATH SOURCE BASE_DIRECTORY ${root} OUTPUT_VARIABLE path)
file(WRITE ${RUN} "#define setUp ${name}_set_up
#define tearDown ${name}_tear_down
#define suiteSetUp ${name}_suite_set_up
#define suiteTearDown ${name}_suite_tear_down
__attribute__((weak)) void setUp(void);
__attribute__((weak)) void tearDown(void);
__attribute__((weak)) void suiteSetUp(void);
__attribute__((weak)) int suiteTearDown(int n_failures);
#include \"${SOURCE}\"
#include \"unit_run.h\"

int ${name}_run(void);

int ${name}_run(void)
{
    unit_begin(\"${path}\", setUp, tearDown, suiteSetUp);
${calls}    return unit_end(suiteTearDown);
}
")
