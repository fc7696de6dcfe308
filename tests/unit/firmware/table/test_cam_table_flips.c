// SPDX-License-Identifier: Apache-2.0
// A table that changes in memory while it is played: bit after bit of the rows around the tool is
// flipped. Nothing undefined happens (the presets with sanitizers run this too), the
// set-point of U stays within its limits, and the guard or the background check ends the cut.
#define OWN_SET_UP
#include "fixture_random.h" // fixture_rarer
#include "rig_bench.h"
#include <stdio.h> // snprintf

/// Of the bits each fifth is flipped, which comes to every place of a knot.
enum { turn_ticks = 480, patience_polls = 40, knot_bits = 96u };
enum { stride = fixture_rarer > 1 ? fixture_rarer : 5 };

static fixture_rig_whole_t kept;
static uint32_t n_by_guard, n_by_check;

/// Set-point of U of the last tick, and its step.
static struct {
    int32_t u_q6, step_q6;
} last_set;

static void begin(uint32_t spindle_mrpm)
{
    part.spindle_mrpm = spindle_mrpm;
    fixture_rig_init(&rig, &part, 20000);
    set(cam_param_spindle_acceleration_mrad_per_s2, 2000000000);
    bring(cam_state_cutting);
    fixture_rig_ticks(&rig, turn_ticks);
    fixture_rig_keep(&kept, &rig);
}

/// One tick, in which U moves and accelerates within the limits that the guard has.
static void tick(const char *what)
{
    const cam_guard_config_t *most = &g_cam.config.in_use->guard;
    fixture_rig_tick(&rig);
    const int32_t step_q6 = rig.last.want.u_set_q6 - last_set.u_q6;
    TEST_ASSERT_TRUE_MESSAGE(labs(rig.last.want.u_set_q6 / 64) <= most->range_nm, what);
    TEST_ASSERT_TRUE_MESSAGE(labs(step_q6) <= most->u_vel_q6, what);
    TEST_ASSERT_TRUE_MESSAGE(labs(step_q6 - last_set.step_q6) <= most->u_acc_q6, what);
    last_set.u_q6 = rig.last.want.u_set_q6;
    last_set.step_q6 = step_q6;
}

static bool is_fault(void)
{
    return rig.last.want.state == cam_state_fault;
}

/// Flip a bit of a knot and play on, first without the background check and then with it.
static void play_flip(uint32_t channel, uint32_t knot, uint32_t bit)
{
    char what[80];
    (void)snprintf(what, sizeof what, "channel %u, knot %u, bit %u", (unsigned)channel,
                   (unsigned)knot, (unsigned)bit);
    uint8_t *bytes = (uint8_t *)&fixture_image_knots(&rig.image, channel)[knot];
    fixture_rig_put(&rig, &kept);
    last_set.u_q6 = g_cam.motion.u.set_q6;
    last_set.step_q6 = g_cam.motion.u.set_step_q6;
    bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    for (uint32_t i = 0; i < (uint32_t)turn_ticks && !is_fault(); i++) {
        tick(what);
    }
    n_by_guard += is_fault() ? 1u : 0u;
    n_by_check += is_fault() ? 0u : 1u;
    for (uint32_t i = 0; i < (uint32_t)patience_polls && !is_fault(); i++) {
        cam_machine_poll(&rig.machine);
        tick(what);
    }
    TEST_ASSERT_TRUE_MESSAGE(is_fault(), what);
    for (uint32_t i = 0; i < 100u; i++) { // U retracts
        tick(what);
    }
    bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
}

/// Flip the bits of some knots, from the one that is played on.
static void play_knots(uint32_t channel, const cam_channel_t *ch, uint32_t slice, uint32_t n)
{
    for (uint32_t bit = 0; bit < n * knot_bits; bit += stride) {
        play_flip(channel, (slice << ch->log2_knots) + bit / knot_bits, bit % knot_bits);
    }
}

static uint32_t slice_at(const cam_channel_t *ch)
{
    return cam_eval_height(ch, rig.last.want.z_nm).i;
}

static void test_flipped_bits_of_u_and_x_are_defined_and_caught(void)
{
    n_by_guard = 0;
    n_by_check = 0;
    part = fixture_part_short();
    begin(2500000);
    const cam_table_t *t = &rig.machine.table;
    play_knots(fixture_u, &t->u, slice_at(&t->u), 1u << t->u.log2_knots);
    play_knots(fixture_x, &t->x, slice_at(&t->x), 2);
    TEST_ASSERT_GREATER_THAN_UINT32(200 / stride, n_by_guard);
    TEST_ASSERT_GREATER_THAN_UINT32(200 / stride, n_by_check);
}

static void test_flipped_bits_of_the_speed_are_defined_and_caught(void)
{
    part = fixture_part_modulated();
    begin(1000000);
    const cam_table_t *t = &rig.machine.table;
    play_knots(fixture_speed, &t->speed, slice_at(&t->speed), 1u << t->speed.log2_knots);
}
