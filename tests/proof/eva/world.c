// SPDX-License-Identifier: Apache-2.0
#include "world.h"
#include <string.h> // memcpy

/// Every member takes any number of its range, independently of all others.
#define VISIT(name, member, low, high) member = any(low, high);
#include "ranges_walk.h"

#define UNKNOWN(object) Frama_C_make_unknown((char *)&(object), sizeof(object))

/// Knots of the largest channel. All channels share them, since all their knots are any numbers.
enum { n_knots = cam_table_max_slices * 4096 };

cam_t c;
cam_config_t *cfg;

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
    CHANNEL(EACH)
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
    t->has_stations = any(0, 1) != 0;
    for (int i = 0; i < cam_table_max_lobes; i++) {
#define P lobes[i]
        LOBE(EACH)
#undef P
    }
    t->lobes = lobes;
    t->n_lobes = any(0, cam_table_max_lobes);
}

static void make_learned(cam_learned_t *learned)
{
    for (int i = 0; i < cam_learned_points + 2; i++) {
        learned->c[i] = any(INT16_MIN, INT16_MAX);
        learned->d[i] = any(INT16_MIN, INT16_MAX);
        learned->dm[i] = any(INT16_MIN, INT16_MAX);
    }
}

static void make_config(cam_config_t *config)
{
    Frama_C_make_unknown((char *)config, sizeof *config);
    walk_config(config);
    make_learned(&config->learned);
    make_table(&config->table);
    config->play.excite.wave = wave;
    cam_config_tie(config, true);
}

/// Anything that is not a pointer may be any number, but for what has a range.
static void make_state(void)
{
    UNKNOWN(c.spindle);
    UNKNOWN(c.guard);
    UNKNOWN(c.motion);
    UNKNOWN(c.force);
    UNKNOWN(c.play);
    UNKNOWN(c.jog);
    UNKNOWN(c.acknowledge);
    UNKNOWN(c.bins);
    UNKNOWN(c.plan);
    UNKNOWN(c.request);
    UNKNOWN(c.trace.n_written);
    UNKNOWN(c.trace.ring[0]);
    walk_state(&c);
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
    c.trace.newest = NULL; // the driver `slot` shows that all other records are no worse a place
}
