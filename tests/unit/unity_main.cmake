# SPDX-License-Identifier: Apache-2.0
# Writes MAIN, a program that includes the C file SOURCE and runs each `static void test_NAME(void)`
# of it, in their order.
file(STRINGS ${SOURCE} lines REGEX "^static void test_[A-Za-z0-9_]+\\(void\\)$")
set(calls "")
foreach(line IN LISTS lines)
    string(REGEX REPLACE "^static void (.*)\\(void\\)$" "\\1" test "${line}")
    string(APPEND calls "    UnityDefaultTestRun(${test}, \"${test}\", 0);\n")
endforeach()
# By its place in the project, so that the program has the same bytes wherever that lies.
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH tests)
cmake_path(GET tests PARENT_PATH root)
cmake_path(RELATIVE_PATH SOURCE BASE_DIRECTORY ${root} OUTPUT_VARIABLE name)
file(WRITE ${MAIN} "#include \"${SOURCE}\"

int main(void)
{
    UnityBegin(\"${name}\");
    suiteSetUp();
${calls}    return suiteTearDown(UnityEnd());
}
")
