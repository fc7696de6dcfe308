// SPDX-License-Identifier: Apache-2.0
// What is demanded of the button in plans, and that a loss of command forgets what was to come.
#include "cam_machine.h"
#include "cam_machine_inner.h"
#include "rig_bench.h"

/// 20 ms, 50 ms, 2 s and a minute, rounded up to plans of 400 us or of a tick.
static void test_times_of_the_button_are_plans(void)
{
    static const uint32_t cases[][5] = {
        {20000, 50, 125, 5000, 150000}, {1000, 20, 50, 2000, 60000}, {500, 10, 25, 1000, 30000}};
    for (uint32_t i = 0; i < 3u; i++) {
        fixture_rig_init(&rig, &part, cases[i][0]);
        const cam_acknowledge_config_t cfg = cam_machine_acknowledge_config(&rig.machine);
        TEST_ASSERT_EQUAL_UINT32(cases[i][1], cfg.settle_plans);
        TEST_ASSERT_EQUAL_UINT32(cases[i][2], cfg.least_plans);
        TEST_ASSERT_EQUAL_UINT32(cases[i][3], cfg.most_plans);
        TEST_ASSERT_EQUAL_UINT32(cases[i][4], cfg.good_plans);
    }
}

static void test_waiver_of_the_port_demands_nothing(void)
{
    cam_machine_t *m = &rig.machine;
    m->rights.port.is_acknowledge_waived = false;
    TEST_ASSERT_TRUE(cam_machine_acknowledge_config(m).is_demanded);
    m->rights.port.is_acknowledge_waived = true;
    TEST_ASSERT_FALSE(cam_machine_acknowledge_config(m).is_demanded);
}

static void test_button_is_told_by_what_the_port_has(void)
{
    cam_machine_t *m = &rig.machine;
    cam_status_t status = fixture_rig_status(&rig);
    m->rights.port = (hal_operator_t){.has_acknowledge = true};
    status.acknowledge.phase = cam_acknowledge_pressed;
    TEST_ASSERT_EQUAL_INT(cam_button_needed, cam_machine_rights(m, &status).button);
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, cam_machine_check_acknowledge(m, &status));
    status.acknowledge.phase = cam_acknowledge_given;
    TEST_ASSERT_EQUAL_INT(cam_button_given, cam_machine_rights(m, &status).button);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_check_acknowledge(m, &status));
    status.acknowledge.phase = cam_acknowledge_used;
    TEST_ASSERT_EQUAL_INT(cam_button_given, cam_machine_rights(m, &status).button);
    m->rights.port = (hal_operator_t){0};
    TEST_ASSERT_EQUAL_INT(cam_button_none, cam_machine_rights(m, &status).button);
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge_none, cam_machine_check_acknowledge(m, &status));
    m->rights.port = (hal_operator_t){.is_acknowledge_waived = true};
    TEST_ASSERT_EQUAL_INT(cam_button_waived, cam_machine_rights(m, &status).button);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_check_acknowledge(m, &status));
}

/// Given up or lost: an enable that waited for the state off does not come by itself.
static void test_a_loss_forgets_the_enable_that_waits(void)
{
    cam_machine_t *m = &rig.machine;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_rights_take(&m->rights, 5, true, cam_machine_status(m).tick));
    m->homes_again = true;
    cam_machine_release_command(m);
    TEST_ASSERT_EQUAL_UINT8(0, m->rights.commander);
    TEST_ASSERT_TRUE(m->is_stop_due);
    const cam_status_t status = fixture_rig_status(&rig);
    cam_machine_rights_poll(m, &status);
    TEST_ASSERT_FALSE(m->homes_again);
    TEST_ASSERT_FALSE(m->is_stop_due);
}
