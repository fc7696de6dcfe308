// SPDX-License-Identifier: Apache-2.0
/// fixture_play: play and plan under a spindle that turns exactly, with axes that are where they
/// were commanded to be. The guard's part is played by taking over what play wants.
#ifndef FIXTURE_PLAY_H
#define FIXTURE_PLAY_H

#include "cam/cam_config.h" // cam_config_t
#include "cam/cam_param.h"  // cam_params_t
#include "cam/cam_plan.h"   // cam_plan_t
#include "cam/cam_play.h"   // cam_play_t
#include "fixture_image.h"  // fixture_image_t
#include <stdbool.h>        // bool

/// [turn / 2^32 per tick] of 2500 r/min at 20 kHz: 480 ticks per turn.
#define FIXTURE_PLAY_SPEED_Q32 8947849
/// [nm] one turn's feed and all other defaults are those of fixture_part_short() at this rate.
#define FIXTURE_PLAY_HZ 20000u
/// [ticks] from plan to plan at this rate.
#define FIXTURE_PLAN_TICKS 8

typedef struct {
    fixture_image_t image;
    cam_table_t table;
    cam_params_t params; ///< lead_ns 0; a change needs fixture_play_configure()
    cam_config_t config;
    cam_play_t play;
    cam_plan_t plan;
    cam_motion_t motion;
    int32_t until_plan;            ///< [ticks] to the next plan
    uint32_t tick_hz;              ///< FIXTURE_PLAY_HZ; a change needs fixture_play_configure()
    cam_angle_t angle;             ///< pos_q32 moves on by speed_q32 with every tick
    cam_sense_t in;                ///< axes follow unless held
    bool is_axes_held;             ///< in.actual_nm stays as the test sets it
    cam_want_t want;               ///< of the last tick
    cam_move_t axis[hal_n_axes];   ///< set-points of the last tick
    cam_move_t before[hal_n_axes]; ///< ... of the tick before
    uint32_t n_asked;              ///< serial number of requests
} fixture_play_t;

/// State off, table taken, spindle synced and turning.
void fixture_play_init(fixture_play_t *f, const fixture_part_t *part);
/// Parameters come into force.
void fixture_play_configure(fixture_play_t *f);
/// The guard has entered the fault state, or has ended its retract.
void fixture_play_settle(fixture_play_t *f, bool is_retracted);
/// The next tick sees this request.
void fixture_play_ask(fixture_play_t *f, cam_request_t request);
/// One tick.
void fixture_play_tick(fixture_play_t *f);
void fixture_play_ticks(fixture_play_t *f, uint32_t n);
/// Ask, then one tick.
void fixture_play_do(fixture_play_t *f, cam_request_t request);
/// From off into a state. @return true when it is reached
bool fixture_play_bring(fixture_play_t *f, cam_state_t state);
/// Tick until the approach has ended. @return true when it has
bool fixture_play_approach(fixture_play_t *f);

/// @return [nm] U as the table has it at an angle and height, offset included, in long double
double fixture_play_u_nm(const fixture_play_t *f, int64_t pos_q32, int32_t z_nm);
/// @return [nm] X as the table has it
double fixture_play_x_nm(const fixture_play_t *f, double z_nm);
/// @return smooth step 10 s^3 - 15 s^4 + 6 s^5, clamped
double fixture_play_smooth(double s);
/// @return [turn]
double fixture_play_turns(int64_t pos_q32);

#endif
