// SPDX-License-Identifier: Apache-2.0
#include "fixture_image.h"
#include "sim_cut.h"
#include "unity.h"
#include <math.h>   // sqrt
#include <string.h> // memset, strstr

static fixture_image_t image;
static sim_cut_options_t options;
static sim_cut_t cut;
static sim_session_t session;
static common_error_t error;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    memset(&session, 0, sizeof session);
    options = (sim_cut_options_t){
        .session = {.config = sim_config_defaults(), .seed = 1},
        .is_without_learning = true, // ten turns are shorter than a rehearsal
    };
}

void tearDown(void)
{
    sim_cut_close(&cut);
    sim_session_close(&session);
}

static bool open_cut(void)
{
    memset(&cut, 0, sizeof cut);
    return sim_cut_open(&cut, &options, image.bytes, image.size, "short.camtab", &error);
}

static sim_cut_end_t run(void)
{
    TEST_ASSERT_TRUE_MESSAGE(open_cut(), error.text);
    while (cut.end == sim_cut_running) {
        sim_cut_tick(&cut);
    }
    return cut.end;
}

static void expect_refusal(const char *why)
{
    TEST_ASSERT_FALSE(open_cut());
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, why), error.text);
}

static void wish(const char *name, double value)
{
    TEST_ASSERT_TRUE(sim_wishes_add(&options.wishes, name, value, "test", &error));
}

/// Cut to the end. @return [um] largest error
static double done_um(void)
{
    TEST_ASSERT_EQUAL_INT(sim_cut_done, run());
    return cut.session.work.max_um;
}

static void inject(const char *text)
{
    TEST_ASSERT_TRUE_MESSAGE(sim_inject_parse(&options.session.inject[options.session.n_injects++],
                                              text, sim_inject_in_run, &error),
                             error.text);
}

/// Whatever the operator does to feed and spindle, the form is that of the cut left alone.
static void test_override_hold_and_resume_leave_the_form_as_it_is(void)
{
    const double alone_um = done_um();
    sim_cut_close(&cut);
    inject("feed-override@0.05:30");
    inject("hold@0.2");
    inject("resume@0.6");
    inject("feed-override@0.8:150");
    inject("spindle-override@0.3:90");
    TEST_ASSERT_DOUBLE_WITHIN(0.1, alone_um, done_um());
    TEST_ASSERT_TRUE(cut.session.cut_turns > 25.0);
}

/// The trim is what the part becomes too small by.
static void test_trim_is_on_the_radius_while_it_cuts(void)
{
    options.session.config.lathe.encoder.jitter_counts = 0.0;
    inject("hold@0.08");
    inject("trim@0.2:-3");
    inject("resume@0.6");
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 3.0, done_um());
}

/// The phase turns the oval on the part, and a measured Z is led by the feed.
static void test_wishes_for_the_form_are_cut(void)
{
    wish("phase_udeg", 30e6);
    wish("z_is_measured", 1);
    TEST_ASSERT_TRUE(done_um() < 1.0);
    TEST_ASSERT_TRUE(cut.is_stopped && cut.session.cut_turns >= 10.0);
}

static void test_whole_camshaft_has_a_whole_turn_of_every_lobe(void)
{
    memset(&cut, 0, sizeof cut);
    cut.session.design.shape = sim_shape_lobes;
    cut.session.design.lobes.n_lobes = 2;
    cut.session.table.z_last_nm = 10000000;
    cut.session.table.feed_nm = 1000000;
    cut.session.work.n = cut.session.lobes.gauge[0].n = sim_lobe_dexels;
    cut.session.lobes.gauge[1].n = sim_lobe_dexels - 1;
    TEST_ASSERT_FALSE(sim_cut_is_gauged(&cut));
    TEST_ASSERT_EQUAL_UINT32(1, sim_cut_lobe_without_turn(&cut));
    cut.is_stopped = true;
    cut.session.cut_turns = 9.0;
    TEST_ASSERT_TRUE(sim_cut_is_gauged(&cut)); // it ended before that lobe
    cut.session.cut_turns = 10.0;
    TEST_ASSERT_FALSE(sim_cut_is_gauged(&cut)); // Z led by others: their stop is the end
    cut.session.lobes.gauge[1].n = sim_lobe_dexels;
    TEST_ASSERT_TRUE(sim_cut_is_gauged(&cut));
    TEST_ASSERT_EQUAL_UINT32(2, sim_cut_lobe_without_turn(&cut));
}

static void test_time_is_limited_and_enough_for_engaging_and_disengaging(void)
{
    options.session.max_s = 0.01;
    TEST_ASSERT_EQUAL_INT(sim_cut_timeout, run());
    sim_cut_close(&cut);
    options.session.max_s = 0.0;
    options.rpm = 60.0;
    wish("engage_turns", 30);
    wish("disengage_turns", 70);
    (void)done_um();
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 2.0 * 112.0 + 60.0, cut.max_s);
    TEST_ASSERT_TRUE(cut.port.time_s > 2.0 * 12.0 + 60.0);
}

/// A speed that counts as stopped is no remedy.
static void test_what_cannot_be_cut_is_refused(void)
{
    options.session.config.lathe.spindle_limit_rpm = 900.0;
    expect_refusal("; give at most --rpm 900.000");
    wish("stopped_mrpm", 900001);
    expect_refusal("; no speed helps");
    setUp();
    inject("table-flip@0:99999999");
    expect_refusal("outside the table");
}

static void open_session(void)
{
    TEST_ASSERT_TRUE_MESSAGE(sim_session_open(&session, &options.session, image.bytes, image.size,
                                              "short.camtab", &error),
                             error.text);
    TEST_ASSERT_TRUE_MESSAGE(sim_session_load_design(&session, &error), error.text);
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
    double x_nm;
    double z_nm;
    open_session();
    sim_session_place(&session, &x_nm, &z_nm);
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

/// A tool that goes back over a band, which it has not entered from below, must not touch it.
static void test_what_cuts_on_the_way_back_counts(void)
{
    open_session();
    const double first_mm = session.table.z_first_nm * 1e-6;
    session.design.bands.n = 1;
    session.design.bands.band[0] = (sim_band_t){.low_mm = first_mm,
                                                .high_mm = first_mm + 0.5,
                                                .run_mm = 0.2,
                                                .n_passes = 1,
                                                .feed_mm = {0.1}};
    sim_sample_t at = {.turn = 0.0, .x_nm = 47e6, .z_nm = session.table.z_first_nm};
    sim_session_touch(&session, &at, true, 0.0);
    TEST_ASSERT_EQUAL_UINT64(0, session.work.n);
    at.x_nm = 45e6;
    sim_session_touch(&session, &at, true, 0.0);
    TEST_ASSERT_EQUAL_UINT64(1, session.work.n);
    TEST_ASSERT_DOUBLE_WITHIN(10.0, 1000.0, session.work.max_um);
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
