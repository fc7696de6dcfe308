// SPDX-License-Identifier: Apache-2.0
// Position switches: windows against the drawing's angle in double, dead time, both senses,
// hysteresis, height, and the states in which all are off.
#include "cam_param.h"
#include "cam_switch.h"
#include "cam_build_inner.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>   // floor, fabs
#include <string.h> // memset

#define TURN 4294967296.0
#define TICK_HZ 20000u

static cam_params_t params;
static cam_switches_config_t config;
static cam_switches_t switches;
static cam_tick_record_t record;

/// The parameters of output 1, by their names.
static void set(int32_t per_turn, double on_deg, double off_deg)
{
    params.switch_1_per_turn = per_turn;
    params.switch_1_on_udeg = (int32_t)(on_deg * 1e6);
    params.switch_1_off_udeg = (int32_t)(off_deg * 1e6);
}

static void configure(int32_t sense)
{
    config = cam_windows_build(&params, sense, TICK_HZ);
}

void setUp(void)
{
    params = cam_param_defaults();
    (void)memset(&switches, 0, sizeof switches);
    (void)memset(&record, 0, sizeof record);
    record.angle.is_synced = true;
    record.want.state = cam_state_ready;
    record.angle.speed_q32 = 1; // so slow that half a tick is nothing
}

/// @return bits of the outputs at an angle in the sense of cutting
static uint32_t at(double turn)
{
    record.angle.pos_q32 = (int64_t)floor(turn * TURN);
    const uint32_t outputs = cam_switches_step_isr(&switches, &config, &record);
    TEST_ASSERT_EQUAL_HEX32(0, outputs % hal_out_switch_1);
    return outputs / hal_out_switch_1;
}

/// @return [turn] distance of an angle behind a place, 0 .. 1
static double behind(double turn, double place)
{
    return turn - place - floor(turn - place);
}

/// Random windows, senses, speeds and dead times: wherever the spindle is, the output is what the
/// drawing's angle at the instant of the effect says, but within some millionths of a turn of an
/// edge.
static void test_step_at_any_angle_is_the_window_of_the_drawing(void)
{
    fixture_random_t random = {.state = 16};
    uint32_t n_on = 0;
    for (uint32_t i = 0; i < 20000u / fixture_rarer; i++) {
        const int32_t n = (int32_t)fixture_random_range(&random, 1, 64);
        const int32_t sense = fixture_random_range(&random, 0, 1) != 0 ? 1 : -1;
        const double on_deg = (double)fixture_random_range(&random, -180, 360);
        const double wide_deg = (double)fixture_random_range(&random, 0, 359000) / 1000.0 / n;
        const double end_deg = on_deg + wide_deg;
        const double off_deg = end_deg > 360.0 ? end_deg - 360.0 : end_deg;
        set(n, on_deg, off_deg);
        params.switch_1_dead_time_ns = (int32_t)fixture_random_range(&random, 0, 20000000);
        record.angle.speed_q32 = (int32_t)fixture_random_range(&random, -20000000, 20000000);
        configure(sense);
        (void)memset(&switches, 0, sizeof switches);
        const double turn = (double)fixture_random_range(&random, -1000000, 1000000) / 7919.0;
        const double ahead =
            record.angle.speed_q32 / TURN * (params.switch_1_dead_time_ns * 1e-9 * TICK_HZ + 0.5);
        const double drawn = sense * (turn + ahead);
        const double phase = behind(n * drawn, params.switch_1_on_udeg / 360e6 * n);
        const double width = (params.switch_1_off_udeg - params.switch_1_on_udeg) / 360e6 * n;
        const double wide = width - floor(width);
        // The dead time is rounded to 2^-16 tick, in which the spindle turns less than 1e-7 turn.
        const bool is_near = fabs(phase - wide) < 1e-5 || phase < 1e-5 || phase > 1.0 - 1e-5;
        const uint32_t is_on = phase < wide ? 1u : 0u;
        const uint32_t found = at(turn);
        TEST_ASSERT_TRUE_MESSAGE(is_near || found == is_on, "other than the drawing");
        n_on += found;
    }
    TEST_ASSERT_UINT32_WITHIN(2000 / fixture_rarer, 10000 / fixture_rarer, n_on);
}

/// @return [turn] place at which output 1 changes to `wanted` on the way from a place to another
static double change_at(double from, double to, uint32_t wanted)
{
    const double step = to > from ? 1e-5 : -1e-5;
    double turn = from;
    while ((at(turn) & 1u) != wanted && fabs(turn - to) > 2e-5) {
        turn += step;
    }
    return turn;
}

static void test_step_forth_and_back_changes_at_the_edges(void)
{
    set(1, 36.0, 72.0);
    params.switch_1_hysteresis_udeg = 3600000; // a hundredth of a turn
    configure(1);
    (void)at(0.0);
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.1, change_at(0.0, 0.5, 1));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.2, change_at(0.1, 0.5, 0));
    (void)change_at(0.2, 0.5, 1); // to the end, nothing changes
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.2, change_at(0.5, 0.0, 1));
    TEST_ASSERT_DOUBLE_WITHIN(2e-5, 0.1, change_at(0.2, 0.0, 0));
}

/// Trembling by less than the hysteresis changes nothing, by more it does.
static void test_step_trembling_on_an_edge_does_not_chatter(void)
{
    set(1, 36.0, 72.0);
    params.switch_1_hysteresis_udeg = 360000; // a thousandth of a turn
    configure(1);
    (void)at(0.05);
    TEST_ASSERT_EQUAL_UINT32(1, at(0.1001));
    TEST_ASSERT_EQUAL_UINT32(1, at(0.0992));
    TEST_ASSERT_EQUAL_UINT32(1, at(0.1003));
    TEST_ASSERT_EQUAL_UINT32(0, at(0.0990));
    TEST_ASSERT_EQUAL_UINT32(0, at(0.0999));
    TEST_ASSERT_EQUAL_UINT32(1, at(0.1001));
}

static void test_step_against_its_sense_is_off(void)
{
    set(1, 0.0, 360.0);
    params.switch_1_sense = 1;
    configure(1);
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
    record.angle.speed_q32 = -1;
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5));
    params.switch_1_sense = -1;
    configure(1);
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
}

static void test_step_with_a_height_is_on_between_its_ends_in_the_work(void)
{
    set(1, 0.0, 360.0);
    params.switch_1_z_low_nm = -1000;
    params.switch_1_z_high_nm = 2000;
    configure(1);
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5)); // ready
    record.want.state = cam_state_cutting;
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
    record.want.z_nm = 2000;
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
    record.want.z_nm = 2001;
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5));
    record.want.z_nm = -1001;
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5));
}

static void test_step_without_an_angle_or_in_fault_is_off(void)
{
    set(1, 0.0, 360.0);
    configure(1);
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
    record.want.state = cam_state_fault;
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5));
    record.want.state = cam_state_ready;
    TEST_ASSERT_EQUAL_UINT32(1, at(0.5));
    record.angle.is_synced = false;
    TEST_ASSERT_EQUAL_UINT32(0, at(0.5));
}

/// The outputs are eight, each with its own parameters; each is refreshed in its turn.
static void test_step_of_eight_outputs_keeps_them_apart(void)
{
    for (int32_t i = 0; i < cam_n_switches; i++) {
        const int32_t id = (int32_t)cam_param_switch_1_per_turn + 8 * i;
        TEST_ASSERT_EQUAL(cam_ok, cam_param_set(&params, (cam_param_id_t)id, 1));
        TEST_ASSERT_EQUAL(cam_ok, cam_param_set(&params, (cam_param_id_t)(id + 1), 45000000 * i));
        TEST_ASSERT_EQUAL(cam_ok,
                          cam_param_set(&params, (cam_param_id_t)(id + 2), 45000000 * (i + 1)));
    }
    configure(1);
    TEST_ASSERT_EQUAL_UINT32(8, config.n);
    for (int32_t i = 0; i < 4 * cam_n_switches; i++) {
        const uint32_t bits = at((i + 0.5) / cam_n_switches);
        TEST_ASSERT_EQUAL_UINT32(1u << i % cam_n_switches & switches.open, bits);
    }
    TEST_ASSERT_EQUAL_UINT32(0xFF, switches.open);
}

/// Without its windows an output is off, even where it was the last one and was on.
static void test_step_of_an_output_that_is_no_longer_in_use_is_off(void)
{
    for (uint32_t n = 3; n < 5u; n++) { // whichever output is brought up to date next
        setUp();
        set(1, 0.0, 180.0);
        params.switch_2_per_turn = 1;
        params.switch_2_off_udeg = 180000000;
        configure(1);
        for (uint32_t i = 0; i < n; i++) {
            (void)at(0.25);
        }
        TEST_ASSERT_EQUAL_UINT32(3, at(0.25));
        params.switch_2_per_turn = 0;
        configure(1);
        TEST_ASSERT_EQUAL_UINT32(1, at(0.25));
        TEST_ASSERT_EQUAL_UINT32(0, at(0.75));
    }
}

/// One output is prepared per tick; the next one is always among those in use.
static void test_step_prepares_outputs_in_use_only(void)
{
    set(1, 0, 180);
    params.switch_8_per_turn = 1;
    params.switch_8_off_udeg = 180000000;
    configure(1);
    for (uint32_t i = 0; i < 5u; i++) {
        (void)at(0.25);
    }
    params.switch_8_per_turn = 0;
    configure(1);
    for (uint32_t i = 0; i < 20u; i++) {
        TEST_ASSERT_EQUAL_HEX32(1, at(0.25));
        TEST_ASSERT_EQUAL_UINT32(0, switches.next);
    }
}

/// An output that was out of use for a tick owes nothing to the hysteresis of before.
static void test_step_of_an_output_that_is_in_use_again_is_free(void)
{
    set(1, 0.0, 180.0);
    params.switch_2_per_turn = 1;
    params.switch_2_off_udeg = 180000000;
    params.switch_2_hysteresis_udeg = 5000000;
    configure(1);
    const cam_switches_config_t both = config;
    for (uint32_t i = 0; i < 4u; i++) {
        (void)at(0.25);
    }
    TEST_ASSERT_EQUAL_UINT32(3, at(0.25));
    (void)at(0.501); // off, and held there
    config.n = 1;
    (void)at(0.501);
    config = both;
    TEST_ASSERT_EQUAL_UINT32(2, at(0.4999) & 2u);
}
