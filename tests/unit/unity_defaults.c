// SPDX-License-Identifier: Apache-2.0
// What Unity calls around tests and programs, for those that need nothing there.
#include "unity.h"

__attribute__((weak)) void setUp(void) {}

__attribute__((weak)) void tearDown(void) {}

__attribute__((weak)) void suiteSetUp(void) {}

__attribute__((weak)) int suiteTearDown(int n_failures)
{
    return n_failures;
}
