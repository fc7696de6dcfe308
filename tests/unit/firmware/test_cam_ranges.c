// SPDX-License-Identifier: Apache-2.0
// Configurations of any parameters, for any table and rate of the tick, lie within the ranges from
// which the proof of the interrupt starts (tests/proof).
#include "cam_build.h"
#include "cam_config.h"
#include "cam_entry.h"
#include "cam_param.h"
#include "fixture_random.h"
#include "ranges_config.h"
#include "unity.h"
#include <stdio.h> // snprintf

enum { n_draws = 20000 };

static cam_config_t config;
static fixture_random_t source;
static int n_built;

void setUp(void)
{
    source = (fixture_random_t){.state = 18u};
    n_built = 0;
}

void tearDown(void) {}

static void expect(const char *name, int64_t value, int64_t low, int64_t high)
{
    char text[160];
    (void)snprintf(text, sizeof text, "%s: %lld is not in %lld .. %lld", name, (long long)value,
                   (long long)low, (long long)high);
    TEST_ASSERT_MESSAGE(value >= low && value <= high, text);
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

#define IN(member, low, high) expect(#member, (int64_t)P.member, low, high);

static void expect_axes(const cam_config_t *c)
{
    for (int i = 0; i < hal_n_axes; i++) {
#define P c->play.approach[i]
        LIMITS(IN)
#undef P
#define P c->play.leave[i]
        LIMITS(IN)
#undef P
#define P c->play.hand.limits[i]
        LIMITS(IN)
#undef P
    }
#define P c->guard.u
    LIMITS(IN)
#undef P
#define P c->guard.leave
    LIMITS(IN)
#undef P
#define P c->tell
    for (int i = hal_axis_x; i < hal_n_axes; i++) {
        TELL_AXIS_CONFIG(IN)
    }
#undef P
    expect("u_end_q10", c->play.hand.u_end_q10, 0, INT64_C(1) << 34);
}

static void expect_ranges(const cam_config_t *c)
{
#define P c->spindle
    SPINDLE_CONFIG(IN)
#undef P
#define P c->play
    PLAY_CONFIG(IN)
#undef P
#define P c->play.u
    SCALE_CONFIG(IN)
#undef P
#define P c->play.speed
    SPEED_CONFIG(IN)
#undef P
#define P c->guard
    GUARD_CONFIG(IN)
#undef P
    if (c->play.swing.is_swung) {
#define P c->play.swing
        SWING_CONFIG(IN)
#undef P
    }
    if (c->play.rings.is_on) {
#define P c->play.rings
        RINGS_CONFIG(IN)
#undef P
    }
    for (uint32_t i = 0; i < c->switches.n; i++) {
#define P c->switches.each[i]
        SWITCH_CONFIG(IN)
#undef P
    }
    expect_axes(c);
#define P c->tell
    TELL_CONFIG(IN)
#undef P
}

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
    for (int i = 0; i < n_draws; i++) {
        const uint32_t tick_hz = rates_hz[i % 7];
        const uint32_t clock_hz = i % 3 == 0 ? 1000000u : 480000000u;
        const cam_params_t params = any_params(tick_hz);
        const cam_table_t table = any_table();
        const uint32_t most_mrpm = (uint32_t)drawn(1, cam_table_max_mrpm);
        if (cam_build_config(&config, &params, &table, most_mrpm, tick_hz, clock_hz) == cam_ok) {
            n_built++;
            expect_ranges(&config);
            expect_relations(&config);
        }
    }
    TEST_ASSERT_GREATER_THAN(n_draws / 100, n_built);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_configuration_is_within_the_ranges_of_the_proof);
    return UNITY_END();
}
