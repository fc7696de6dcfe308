// SPDX-License-Identifier: Apache-2.0
#include "world.h"
#include <string.h> // memcpy

/// Every member takes any number of its range, independently of all others.
#define SET(member, low, high) P.member = any(low, high);

/// Knots of the largest channel. All channels share them, since all their knots are any numbers.
enum { n_knots = cam_table_max_slices * 4096 };

cam_t c;
cam_config_t *cfg;
cam_tick_record_t record;

static int32_t words[3 * n_knots];
static const cam_knot_t *const knots = (const cam_knot_t *)(const void *)words;
static cam_lobe_t lobes[cam_table_max_lobes];
static int32_t wave[WAVE_SAMPLES];

static void make_knots(void)
{
    for (int i = 0; i < 3; i++) {
        words[i] = any(-CAM_TABLE_SUM_MAX, CAM_TABLE_SUM_MAX);
    }
    //@ loop unroll 24;
    for (uint32_t n = 1; n < n_knots; n *= 2) {
        memcpy(words + 3 * n, words, n * sizeof(cam_knot_t));
    }
}

static void make_channel(cam_channel_t *ch, bool is_around, int32_t most_offset)
{
#define P (*ch)
    CHANNEL(SET)
#undef P
    ch->knots = knots;
    ch->log2_knots = is_around ? any(2, 12) : 0u;
    ch->log2_repeat = is_around ? any(0, 4) : 0u;
    ch->value_offset = any(-most_offset, most_offset);
}

static void make_table(cam_table_t *t)
{
    make_channel(&t->u, true, (1 << 23) - 1);
    make_channel(&t->x, false, 2000000000);
    make_channel(&t->speed, true, 4 * CAM_TABLE_RATIO_ONE);
    make_channel(&t->angle, true, CAM_TABLE_ANGLE_MAX);
    make_channel(&t->way, false, 2000000000);
    t->speed.knots = any(0, 1) != 0 ? knots : NULL;
    t->angle.knots = any(0, 1) != 0 ? knots : NULL;
    t->way.knots = any(0, 1) != 0 ? knots : NULL;
    t->has_stations = any(0, 1) != 0;
    for (int i = 0; i < cam_table_max_lobes; i++) {
#define P lobes[i]
        LOBE(SET)
#undef P
    }
    t->lobes = lobes;
    t->n_lobes = any(0, cam_table_max_lobes);
}

static void make_play(cam_play_config_t *play)
{
#define P (*play)
    PLAY_CONFIG(SET)
#undef P
#define P play->u
    SCALE_CONFIG(SET)
#undef P
#define P play->swing
    SWING_CONFIG(SET)
#undef P
#define P play->rings
    RINGS_CONFIG(SET)
#undef P
#define P play->speed
    SPEED_CONFIG(SET)
#undef P
#define P play->excite
    EXCITE_CONFIG(SET)
#undef P
#define P play->acknowledge
    ACKNOWLEDGE_CONFIG(SET)
#undef P
#define P play->hand.order
    ORDER(SET)
#undef P
    for (int i = 0; i < hal_n_axes; i++) {
#define P play->approach[i]
        LIMITS(SET)
#undef P
#define P play->leave[i]
        LIMITS(SET)
#undef P
#define P play->hand.limits[i]
        LIMITS(SET)
#undef P
    }
    play->hand.u_end_q10 = any(0, INT64_C(1) << 34);
    play->excite.wave_nm = wave;
    play->feed_q32 = any(0, PART_MOST); // README.md, "What is assumed"
}

static void make_learned(cam_learned_t *learned)
{
    for (int i = 0; i < cam_learn_points + 2; i++) {
        learned->c[i] = any(INT16_MIN, INT16_MAX);
        learned->d[i] = any(INT16_MIN, INT16_MAX);
        learned->dm[i] = any(INT16_MIN, INT16_MAX);
    }
}

static void make_config(cam_config_t *config)
{
#define P config->spindle
    SPINDLE_CONFIG(SET)
#undef P
    make_play(&config->play);
#define P config->guard
    GUARD_CONFIG(SET)
#undef P
#define P config->guard.u
    LIMITS(SET)
#undef P
#define P config->guard.leave
    LIMITS(SET)
#undef P
#define P config->tell
    TELL_CONFIG(SET)
    for (int i = 0; i < hal_n_axes; i++) {
        TELL_AXIS_CONFIG(SET)
    }
#undef P
    config->switches.n = any(0, cam_n_switches);
    for (int i = 0; i < cam_n_switches; i++) {
#define P config->switches.each[i]
        SWITCH_CONFIG(SET)
#undef P
    }
    config->generation = any(0, UINT32_MAX);
    make_learned(&config->learned);
    make_table(&config->table);
    cam_config_tie(config, true);
}

static void make_axis(cam_move_t *axis)
{
#define P (*axis)
    AXIS(SET)
#undef P
}

static void make_glide(cam_glide_t *glide)
{
#define P (*glide)
    GLIDE(SET)
#undef P
    make_axis(&glide->raw);
    for (int i = 0; i < 1 << cam_glide_most_log2; i++) {
        glide->past_q10[i] = any(INT32_MIN, INT32_MAX);
    }
}

static void make_motion(cam_motion_t *motion)
{
#define P (*motion)
    MOTION(SET)
#undef P
    for (int i = 0; i < hal_n_axes; i++) {
        make_axis(&motion->axis[i]);
        make_glide(&motion->glide[i]);
        motion->change_q10[i] = any(INT32_MIN, INT32_MAX);
    }
}

static void make_state(void)
{
#define P c.spindle
    SPINDLE(SET)
#undef P
    make_motion(&c.motion);
#define P c.play
    PLAY(SET)
#undef P
    for (int i = 0; i < cam_play_history; i++) {
        c.play.history_q6[i] = any(INT32_MIN, INT32_MAX);
    }
#define P c.guard
    GUARD(SET)
#undef P
#define P c.tell
    TELL(SET)
#undef P
    make_axis(&c.guard.u);
    make_glide(&c.guard.glide);
    for (int i = 0; i < hal_n_axes; i++) {
        c.tell.vel_q10[i] = any(INT32_MIN, INT32_MAX);
    }
#define P c.acknowledge
    ACKNOWLEDGE(SET)
#undef P
    for (int i = 0; i < cam_guard_count_bits; i++) {
        c.guard.count[i] = any(0, UINT32_MAX);
    }
#define P c.switches
    SWITCHES(SET)
#undef P
    for (int i = 0; i < cam_n_switches; i++) {
        c.switches.begin_q32[i] = any(0, UINT32_MAX);
        c.switches.left_q32[i] = any(0, UINT32_MAX);
    }
#define P c.hand
    HAND(SET)
#undef P
#define P c.plan
    PLAN(SET)
#undef P
}

void make_world(void)
{
    make_knots();
    for (int i = 0; i < WAVE_SAMPLES; i++) {
        wave[i] = any(-15000000, 15000000);
    }
    cfg = &c.config.half[0];
    make_config(cfg);
    c.config.offered = cfg;
    c.config.in_use = cfg;
    make_state();
    c.until_plan = any(-1, 40);
    c.n_ticks = any(0, UINT32_MAX);
    c.request = any(0, UINT32_MAX);
    for (int i = 0; i < 2 * cam_learn_bins; i++) {
        c.gather.bin[i].error_q6 = any(INT32_MIN, INT32_MAX);
        c.gather.bin[i].u_nm = any(INT32_MIN, INT32_MAX);
        c.gather.bin[i].angle_q24 = any(INT32_MIN, INT32_MAX);
        c.gather.bin[i].n = any(0, UINT32_MAX);
    }
#define P record
    RECORD(SET)
#undef P
}
