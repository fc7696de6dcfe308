// SPDX-License-Identifier: Apache-2.0
// The words by which the Linux port names a lost node and its error.
#include "lin_bus.h"
#include "unity.h"
#include <string.h> // strlen

static lin_config_t config;

void setUp(void)
{
    config = lin_config_defaults();
}

static void expect_line(lin_cause_t cause, bool is_drives, const char *expected)
{
    char line[lin_line_bytes];
    const lin_cause_t same = lin_cause_unpack(lin_cause_pack(cause));
    (is_drives ? lin_cause_drives_text : lin_cause_bus_text)(same, &config, line, sizeof line);
    TEST_ASSERT_EQUAL_STRING(expected, line);
}

static void test_words_name_the_node_and_its_error(void)
{
    expect_line((lin_cause_t){.loss = lin_loss_none}, false, "bus: all nodes are heard");
    expect_line((lin_cause_t){.loss = lin_loss_bus_off}, false, "bus: bus-off");
    expect_line((lin_cause_t){lin_loss_heartbeat, 3, 0}, false,
                "bus: node 3 (drive x): no heartbeat");
    expect_line((lin_cause_t){lin_loss_emcy, 1, 0x5000}, false,
                "bus: node 1 (encoder): reports an error: error code 5000h");
    expect_line((lin_cause_t){.loss = lin_loss_none}, true, "drives: ready");
    expect_line((lin_cause_t){lin_loss_none, 5, 0xFF01}, true,
                "drives: node 5 (spindle) is not ready: error code FF01h");
    expect_line((lin_cause_t){lin_loss_pdo, 3, 0}, true,
                "drives: node 3 (drive x) is not ready: no measured values");
    for (int loss = 0; loss <= lin_loss_spindle; loss++) {
        TEST_ASSERT_GREATER_THAN(5, strlen(lin_loss_text((lin_loss_t)loss)));
    }
}
