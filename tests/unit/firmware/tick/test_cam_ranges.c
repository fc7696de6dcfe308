// SPDX-License-Identifier: Apache-2.0
// Configurations of any parameters, for any table and rate of the tick, lie within the ranges from
// which the proof of the interrupt starts (tests/proof), and so does its first state. tests/fuzz
// looks at the configurations and states of sessions.
#include "cam_build.h"
#include "cam_config.h"
#include "cam_table_inner.h"
#include "cam_param.h"
#include "fixture_random.h"
#include "hal_host.h"
#include "unity.h"
#include <stdio.h> // snprintf

enum { n_draws = 20000 / fixture_rarer };

static cam_config_t config;
static fixture_random_t source;

void setUp(void)
{
    source = (fixture_random_t){.state = 18u};
    hal_host_reset(20000);
}

static void refuse(const char *name, int64_t value, int64_t low, int64_t high)
{
    char text[160];
    (void)snprintf(text, sizeof text, "%s: %lld is not in %lld .. %lld", name, (long long)value,
                   (long long)low, (long long)high);
    TEST_FAIL_MESSAGE(text);
}

/// Inline, since every tick has hundreds of them.
static inline void expect(const char *name, int64_t value, int64_t low, int64_t high)
{
    if (value < low || value > high) {
        refuse(name, value, low, high);
    }
}

/// @return a number of a range: an end of it, one near 0 or 1, or any
static int64_t drawn(int64_t low, int64_t high)
{
    const int64_t small = fixture_random_range(&source, -2, 1000);
    switch (fixture_random_range(&source, 0, 5)) {
    case 0:
        return low;
    case 1:
        return high;
    case 2:
        return small < low ? low : small > high ? high : small;
    default:
        return fixture_random_range(&source, low, high);
    }
}

static cam_params_t any_params(uint32_t tick_hz)
{
    cam_params_t params = cam_param_defaults();
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        const cam_param_info_t *info = cam_param_info(id);
        const int32_t value = (int32_t)drawn(info->min, info->max);
        const bool is_moved = fixture_random_range(&source, 0, 3) != 0;
        const cam_err_t err = is_moved ? cam_param_set(&params, id, value) : cam_ok;
        TEST_ASSERT_TRUE(err == cam_ok || value == 0); // a sign cannot be 0
    }
    params.observer_bandwidth_mHz = (int32_t)drawn(1000, tick_hz * INT64_C(80));
    return params;
}

/// @return a number from 0 on whose size is any
static int32_t sized(int64_t high)
{
    const int64_t most = INT64_C(1) << fixture_random_range(&source, 0, 30);
    return (int32_t)drawn(0, most < high ? most : high);
}

/// Parameters of a position loop; half of them fit one another.
static void any_loop(cam_params_t *p, uint32_t tick_hz)
{
    p->servo_pole_hz = (int32_t)drawn(10, tick_hz / 5u);
    p->servo_crossover_hz = sized(p->servo_pole_hz < 5000 ? p->servo_pole_hz : 5000);
    p->servo_integral_mHz = sized(p->servo_crossover_hz < 1000 ? p->servo_crossover_hz * 1000 : 0);
    p->servo_notch_hz = drawn(0, 1) == 0 ? 0 : (int32_t)drawn(tick_hz / 1000u + 1u, tick_hz / 4u);
    p->servo_notch_pole_permille = (int32_t)drawn(1, 2000);
    p->servo_notch_zero_permille = (int32_t)drawn(0, p->servo_notch_pole_permille);
    p->servo_continuous_mn = (int32_t)drawn(300000, 4000000);
    p->servo_force_limit_mn = 4000000;
    p->servo_mass_g = 10 + sized(99990);
    p->servo_stiffness_n_per_m = sized(100000000);
    p->servo_drag_mn_s_per_m = sized(10000000);
}

static void any_channel(cam_channel_t *ch, bool is_around)
{
    static const cam_knot_t knots[1];
    ch->knots = knots;
    ch->n_slices = (uint32_t)drawn(2, cam_table_max_slices);
    ch->log2_knots = is_around ? (uint32_t)drawn(2, 12) : 0u;
    ch->log2_repeat = is_around ? (uint32_t)drawn(0, 4) : 0u;
    ch->frac_bits = (uint32_t)drawn(0, 8);
}

/// @return what the configuration takes of a table, within the limits of its check
static cam_table_t any_table(void)
{
    cam_table_t t = {.direction = drawn(0, 1) == 0 ? -1 : 1};
    any_channel(&t.u, true);
    any_channel(&t.x, false);
    t.u.value_offset = (int32_t)drawn(-(1 << 23) + 1, (1 << 23) - 1);
    t.x.value_offset = (int32_t)drawn(-cam_entry_max_height_nm, cam_entry_max_height_nm);
    t.x_max_nm = (int32_t)drawn(t.x.value_offset - (INT64_C(1) << 25), t.x.value_offset);
    if (drawn(0, 1) == 0) {
        any_channel(&t.speed, true);
    }
    if (drawn(0, 1) == 0) {
        any_channel(&t.angle, true);
        t.angle.value_offset = (int32_t)drawn(-CAM_TABLE_ANGLE_MAX, CAM_TABLE_ANGLE_MAX);
        t.is_swung = true;
    }
    t.is_ring_helix = drawn(0, 1) == 0;
    t.z_first_nm = (int32_t)drawn(-cam_entry_max_height_nm / 2, cam_entry_max_height_nm / 2 - 1);
    t.z_last_nm = (int32_t)drawn((int64_t)t.z_first_nm + 1, cam_entry_max_height_nm / 2);
    t.spindle_mrpm = (uint32_t)drawn(1, cam_table_max_mrpm);
    t.feed_nm = (uint32_t)drawn(1, cam_table_max_feed_nm);
    t.limit_u_stroke_nm = (uint32_t)drawn(1, 1 << 25);
    t.u_min_nm = (int32_t)drawn(-(1 << 24), 1 << 24);
    t.u_max_nm = (int32_t)drawn(t.u_min_nm, 1 << 24);
    return t;
}

#define VISIT(name, member, low, high) expect(name, (int64_t)(member), low, high);
#include "ranges_walk.h"

/// Relations that the proof takes from here, because its ranges do not hold them.
static void expect_relations(const cam_config_t *c)
{
    const cam_play_config_t *p = &c->play;
    TEST_ASSERT_TRUE((p->engage_q32 >> 8) * (int64_t)p->per_engage_q31 <= INT64_C(1) << 55);
    TEST_ASSERT_TRUE((p->disengage_q32 >> 8) * (int64_t)p->per_disengage_q31 <= INT64_C(1) << 55);
    TEST_ASSERT_TRUE((int64_t)p->per_plan_q30 * p->plan_ticks <= Q30);
    TEST_ASSERT_TRUE((int64_t)p->amplitude_step_q30 * p->plan_ticks <= Q30 / 32);
    TEST_ASSERT_TRUE((int64_t)p->height_max_q32 < ((int64_t)c->table.u.n_slices - 1) * TURN);
    TEST_ASSERT_TRUE(c->guard.u_retract_q10 == p->u_retract_q10);
}

static void test_every_configuration_is_within_the_ranges_of_the_proof(void)
{
    static const uint32_t rates_hz[] = {500u, 1000u, 2500u, 8000u, 20000u, 50000u, 100000u};
    int n_built = 0;
    int n_loops = 0;
    for (int i = 0; i < n_draws; i++) {
        const uint32_t tick_hz = rates_hz[i % 7];
        const uint32_t clock_hz = i % 3 == 0 ? 1000000u : 480000000u;
        cam_params_t params = any_params(tick_hz);
        hal_host.slow.force.quantum_un = i % 2 == 0 ? 0u : 20000u;
        any_loop(&params, tick_hz);
        const cam_table_t table = any_table();
        const uint32_t most_mrpm = (uint32_t)drawn(1, cam_table_max_mrpm);
        if (cam_build_config(&config, &params, &table, most_mrpm, tick_hz, clock_hz).err ==
            cam_ok) {
            cam_config_learn(&config);
            n_built++;
            n_loops += config.force.is_used && config.force.servo.limit_q6 > 0 ? 1 : 0;
            walk_config(&config);
            expect_relations(&config);
        }
    }
    TEST_ASSERT_GREATER_THAN(n_draws / 100, n_built);
    TEST_ASSERT_GREATER_THAN(n_draws / 1000, n_loops);
}

static void test_first_tick_starts_within_the_ranges_of_the_proof(void)
{
    static cam_t fresh;
    walk_state(&fresh);
}
