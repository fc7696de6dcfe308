// SPDX-License-Identifier: Apache-2.0
#include "fixture_image.h"
#include "sim_session.h"
#include "unity.h"
#include <math.h>   // sqrt
#include <string.h> // memset

static fixture_image_t image;
static sim_session_options_t options;
static sim_session_t session;
static common_error_t error;
static double x_nm, z_nm;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    memset(&session, 0, sizeof session);
    options = (sim_session_options_t){.config = sim_config_defaults(), .seed = 1};
}

void tearDown(void)
{
    sim_session_close(&session);
}

static void open_session(void)
{
    TEST_ASSERT_TRUE_MESSAGE(
        sim_session_open(&session, &options, image.bytes, image.size, "short.camtab", &error),
        error.text);
    TEST_ASSERT_TRUE_MESSAGE(sim_session_load_design(&session, &error), error.text);
    sim_session_place(&session, &x_nm, &z_nm);
}

static void inject(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(
        sim_inject_parse(&options.inject[options.n_injects++], text, sim_inject_in_run, &error),
        error.text);
}

/// Take a sample at a time, on the first height of the part.
static void touch(double t_s, double turn, bool is_cutting, double following_nm)
{
    const sim_sample_t at = {
        .t_s = t_s, .turn = turn, .x_nm = 45e6, .z_nm = session.table.z_first_nm};
    sim_session_touch(&session, &at, is_cutting, following_nm);
}

static void test_axes_start_off_the_blank_and_before_the_part(void)
{
    open_session();
    TEST_ASSERT_EQUAL_DOUBLE((session.work.blank_mm + 2.0) * 1e6, x_nm);
    TEST_ASSERT_EQUAL_DOUBLE(session.table.z_first_nm - 2e6, z_nm);
}

static void test_following_error_counts_while_cutting_only(void)
{
    open_session();
    TEST_ASSERT_EQUAL_DOUBLE(0.0, sim_session_following_rms_um(&session));
    touch(1.0, 5.0, false, 9000.0);
    touch(2.0, 6.0, true, 3000.0);
    touch(3.0, 8.5, true, -4000.0);
    touch(4.0, 9.0, false, 9000.0);
    TEST_ASSERT_EQUAL_DOUBLE(4.0, session.following_max_um);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, sqrt((9.0 + 16.0) / 2.0),
                              sim_session_following_rms_um(&session));
    TEST_ASSERT_EQUAL_DOUBLE(2.5, session.cut_turns);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, session.cut_s);
}

static void test_injections_are_due_once_by_the_clock_or_by_the_cut(void)
{
    inject("estop@0.5");
    inject("drive@t1.5");
    open_session();
    TEST_ASSERT_NULL(sim_session_next_inject(&session, 1.0));
    TEST_ASSERT_EQUAL_INT(sim_inject_drive, sim_session_next_inject(&session, 1.5)->kind);
    TEST_ASSERT_NULL(sim_session_next_inject(&session, 9.0)); // nothing is cut yet
    touch(2.0, 0.0, true, 0.0);
    TEST_ASSERT_NULL(sim_session_next_inject(&session, 2.4));
    TEST_ASSERT_EQUAL_INT(sim_inject_estop, sim_session_next_inject(&session, 2.5)->kind);
    TEST_ASSERT_NULL(sim_session_next_inject(&session, 9.0));
    TEST_ASSERT_EQUAL_UINT32(0, session.n_waiting);
}
