// SPDX-License-Identifier: Apache-2.0
// Which commands anybody on the bus may give, one by one, and that all others need command.
#include "can_bench.h"
#include "unity.h"
#include <string.h> // memchr

/// Stop, everything that only reads, and asking for command.
static void test_a_stranger_may_read_and_stop_and_nothing_else(void)
{
    static const uint8_t free[] = {4, 7, 9, 10, 20, 23, 28, 37, 46, 56, 57, 59, 60};
    for (uint32_t command = 0; command <= UINT8_MAX; command++) {
        setUp();
        const fixture_answer_t a = fixture_can_command_from(&f, (uint8_t)command, 0, 0, 99, 0);
        const bool is_free = memchr(free, (int)command, sizeof free) != NULL;
        const bool is_take = command == 60u; // somebody has it already, and it is said likewise
        TEST_ASSERT_EQUAL_MESSAGE(is_free && !is_take, a.result != cam_err_not_commander,
                                  is_free ? "is refused" : "is admitted");
        TEST_ASSERT_EQUAL_UINT8(1, f.rig.machine.rights.commander);
    }
}
