# SPDX-License-Identifier: Apache-2.0
# Writes MAIN, a program that includes the C file SOURCE and runs each `static void test_NAME(void)`
# of it, in their order.
file(STRINGS ${SOURCE} lines REGEX "^static void test_[A-Za-z0-9_]+\\(void\\)$")
list(TRANSFORM lines REPLACE "^static void (.*)\\(void\\)$" "    UnityDefaultTestRun(\\1, \"\\1\", 0);\n")
list(JOIN lines "" calls)
file(CONFIGURE OUTPUT ${MAIN} @ONLY CONTENT [[
#include "@SOURCE@"

int main(void)
{
    UnityBegin("@SOURCE@");
    suiteSetUp();
@calls@    return suiteTearDown(UnityEnd());
}
]])
