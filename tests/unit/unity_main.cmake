# SPDX-License-Identifier: Apache-2.0
# Writes MAIN, a program that includes the C file SOURCE and runs each `static void test_NAME(void)`
# of it, in their order.
file(STRINGS ${SOURCE} lines REGEX "^static void test_[A-Za-z0-9_]+\\(void\\)$")
set(calls "")
foreach(line IN LISTS lines)
    string(REGEX REPLACE "^static void (.*)\\(void\\)$" "\\1" test "${line}")
    string(APPEND calls "    UnityDefaultTestRun(${test}, \"${test}\", 0);\n")
endforeach()
file(WRITE ${MAIN} "#include \"${SOURCE}\"

int main(void)
{
    UnityBegin(\"${SOURCE}\");
    suiteSetUp();
${calls}    return suiteTearDown(UnityEnd());
}
")
