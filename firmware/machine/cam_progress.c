// SPDX-License-Identifier: Apache-2.0
#include "cam_machine.h"
#include "cam_feasible.h" // cam_changes_feed_ppm
#include "cam_state.h"    // cam_state_is_in_work
#include <stdatomic.h>    // atomic_load_explicit
#include <stddef.h>       // NULL

static int64_t at_least_0(int64_t turns_q32)
{
    return turns_q32 > 0 ? turns_q32 : 0;
}

/// @return [turn] of a feed from rest to rest. At rate r the ramps at both ends are r times as long
///         and feed half of what full rate would
/// @param fed_q32  [turn at full rate] distance
/// @param ppm      feed rate in force; a hold, 0, counts as full rate
static int64_t feed_turns_q32(const cam_play_config_t *cfg, int64_t fed_q32, int32_t ppm)
{
    enum { whole_ppm = 1000000 };
    const int64_t rate_ppm = ppm > 0 ? ppm : whole_ppm;
    const int64_t fed_q12 = fed_q32 >> 20; // below 2^44 for any part, times 10^6 below 2^64
    return (int64_t)((uint64_t)fed_q12 * whole_ppm / (uint64_t)rate_ppm << 20) +
           cfg->ramp_q32 / whole_ppm * rate_ppm;
}

/// @return [turn] of the feed after a hold that is resumed at once
static int64_t held_q32(const cam_feed_motion_t *c, const cam_play_config_t *cfg, int32_t ppm)
{
    return cfg->rings.is_on
               ? cfg->feed_q32 - at_least_0(c->end_q32 - c->from_q32)
               : feed_turns_q32(cfg, at_least_0(cfg->feed_q32 - cfg->ramp_q32 - c->fed_end_q32),
                                ppm);
}

/// @return [turn] to the end of the planned motion
static int64_t laid_q32(const cam_moment_t *now, const cam_play_config_t *cfg, int32_t ppm)
{
    const cam_plan_t *p = &now->plan;
    const bool is_held = p->feed_motion.is_held && !p->is_stopped && !p->is_rehearsal;
    if (is_held) {
        return at_least_0(p->feed_motion.end_q32 - now->record.angle.pos_q32) +
               held_q32(&p->feed_motion, cfg, ppm) + cfg->disengage_q32;
    }
    return at_least_0(p->disengage_at_q32 + cfg->disengage_q32 - now->record.angle.pos_q32);
}

/// Fill in the turns of a pass that ends by itself. State and is_playing are the planned ones; the
/// record has the previous state.
static void count(cam_progress_t *to, const cam_moment_t *now, const cam_play_config_t *cfg,
                  int32_t ppm)
{
    const int64_t ends = cfg->engage_q32 + cfg->disengage_q32;
    const int64_t rehearsal = cfg->rehearse_q32 > 0 ? ends + cfg->rehearse_q32 : 0;
    const int64_t feed =
        cfg->rings.is_on ? cfg->feed_q32 : feed_turns_q32(cfg, cfg->feed_q32 - cfg->ramp_q32, ppm);
    const int64_t cut = ends + cfg->settle_q32 + feed;
    int64_t done = now->motion.is_playing
                       ? at_least_0(now->record.angle.pos_q32 - now->plan.engage_at_q32)
                       : 0;
    if (!cam_state_is_in_work(now->motion.state)) {
        to->left_q32 = rehearsal + cut;
    } else if (now->motion.state == cam_state_rehearsing) {
        to->left_q32 = now->motion.is_playing ? laid_q32(now, cfg, ppm) : rehearsal;
        to->left_q32 += now->motion.is_playing && now->plan.is_stopped ? 0 : cut;
    } else {
        done += rehearsal;
        to->left_q32 = now->motion.is_playing ? laid_q32(now, cfg, ppm) : cut;
    }
    to->whole_q32 = done + to->left_q32;
}

cam_progress_t cam_progress(const cam_machine_t *m)
{
    const cam_config_t *cfg = atomic_load_explicit(&m->core->config.in_use, memory_order_acquire);
    cam_progress_t to = {.has_end = false};
    if (!m->has_table || cfg == NULL || cfg->play.table == NULL) {
        return to;
    }
    cam_moment_t now;
    cam_status_moment(m->core, &now);
    const int32_t mrpm = cfg->play.spindle_mrpm;
    const uint32_t speed = mrpm < 0 ? 0u - (uint32_t)mrpm : (uint32_t)mrpm;
    to.mrpm = (uint32_t)((uint64_t)speed * (uint32_t)cfg->play.spindle_rate_q30 >> 30);
    to.has_end = !cfg->play.is_z_measured || now.motion.state == cam_state_disengaging;
    if (to.has_end) {
        count(&to, &now, &cfg->play, cam_changes_feed_ppm(&m->params));
    }
    return to;
}
