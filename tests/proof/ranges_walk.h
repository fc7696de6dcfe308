// SPDX-License-Identifier: Apache-2.0
/// ranges_walk: goes through every member that ranges_config.h and ranges_state.h name. Before it
/// is included, VISIT(name, member, lowest, highest) says what is done with each of them: the proof
/// lets it be any number of its range, and looks behind the tick whether it is within it again;
/// tests/fuzz looks at it after every tick of its sessions.
#ifndef PROOF_RANGES_WALK_H
#define PROOF_RANGES_WALK_H

#include "cam_tick.h"     // cam_t
#include "ranges_state.h" // all ranges

#define WALK_TEXT(text) #text
#define WALK_NAME(place, member) WALK_TEXT(place) "." #member
#define EACH(member, low, high) VISIT(WALK_NAME(P, member), P.member, low, high)

static inline void walk_limits(cam_motion_limits_t *limits)
{
#define P (*limits)
    LIMITS(EACH)
#undef P
}

static inline void walk_swing_config(cam_swing_config_t *swing)
{
#define P (*swing)
    SWING_CONFIG(EACH)
#undef P
}

/// What a table or a wave brings is there only with them; without them it is 0.
static inline void walk_optional(cam_play_config_t *play)
{
#define P play->rings
    RINGS_CONFIG(EACH)
#undef P
#define P play->excite
    EXCITE_CONFIG(EACH)
#undef P
    walk_swing_config(&play->swing);
}

static inline void walk_play_config(cam_play_config_t *play)
{
#define P (*play)
    PLAY_CONFIG(EACH)
#undef P
#define P play->u
    SCALE_CONFIG(EACH)
#undef P
#define P play->speed
    SPEED_CONFIG(EACH)
#undef P
#define P play->acknowledge
    ACKNOWLEDGE_CONFIG(EACH)
#undef P
#define P play->jog.order
    ORDER(EACH)
#undef P
    for (int i = 0; i < hal_n_axes; i++) {
        walk_limits(&play->approach[i]);
        walk_limits(&play->leave[i]);
        walk_limits(&play->jog.limits[i]);
    }
    walk_optional(play);
}

static inline void walk_guard_config(cam_guard_config_t *guard)
{
#define P (*guard)
    GUARD_CONFIG(EACH)
#undef P
    walk_limits(&guard->u);
}

static inline void walk_command_config(cam_axis_command_config_t *command)
{
#define P (*command)
    COMMAND_CONFIG(EACH)
    for (int i = 0; i < hal_n_axes; i++) {
        COMMAND_AXIS_CONFIG(EACH)
    }
#undef P
}

static inline void walk_config(cam_config_t *cfg)
{
#define P cfg->spindle
    SPINDLE_CONFIG(EACH)
#undef P
    walk_play_config(&cfg->play);
    walk_guard_config(&cfg->guard);
    walk_command_config(&cfg->command);
#define P cfg->force
    FORCE_CONFIG(EACH)
#undef P
#define P (*cfg)
    WHOLE_CONFIG(EACH)
#undef P
}

static inline void walk_filter(cam_jerk_filter_t *filter)
{
#define P (*filter)
    JERK_FILTER(EACH)
#undef P
}

static inline void walk_motion(cam_motion_t *motion)
{
#define P (*motion)
    MOTION(EACH)
#undef P
    for (int i = 0; i < hal_n_axes; i++) {
        walk_filter(&motion->filter[i]);
    }
}

static inline void walk_plan(cam_plan_t *plan)
{
#define P (*plan)
    PLAN(EACH)
#undef P
#define P plan->feed_motion
    FEED_MOTION(EACH)
#undef P
}

static inline void walk_state(cam_t *c)
{
#define P c->spindle
    SPINDLE(EACH)
#undef P
    walk_motion(&c->motion);
#define P c->play
    PLAY(EACH)
#undef P
#define P c->force
    FORCE(EACH)
#undef P
#define P c->acknowledge
    ACKNOWLEDGE(EACH)
#undef P
#define P c->jog
    JOG(EACH)
#undef P
    walk_plan(&c->plan);
    for (int i = 0; i < 2; i++) {
#define P c->trace.ring[i]
        SENSED(EACH)
#undef P
    }
#define P (*c)
    WHOLE_STATE(EACH)
#undef P
}

#endif
