// SPDX-License-Identifier: Apache-2.0
/// cam_turn_bins: per-turn error bins for learning, and the learned tables.
///
/// In every tick the interrupt adds the error of U to one of 128 bins per turn; in a turn of more
/// than 2^14 ticks only in every 2nd, 4th .. 64th one. Two banks of bins alternate from turn to
/// turn: the bank is the lowest bit of the turn number, so a bank holds exactly one turn. While one
/// bank fills, the slow side reads and clears the other one:
///
///     turn      | k - 1      | k          | k + 1      |
///     interrupt | odd bank   | even bank  | odd bank   |
///     slow side |            | reads and clears k - 1, until three quarters of turn k
///
/// From them the slow side computes cam_learned_t, which reaches the interrupt as a part of the
/// configuration (cam_config_copy()): feed-forward gains, a correction c of U's command and
/// the deviation d of the spindle from uniform rotation. Tables and bins are functions of the
/// spindle angle; the slow side rotates them by the operator's phase. All-zero tables correct
/// nothing. Source: MATHS.md (135) .. (138). Context: cam_turn_bins_take() and
/// cam_turn_bins_release(): slow side, one caller; all others: ISR, constant time.
#ifndef CAM_TURN_BINS_H
#define CAM_TURN_BINS_H

#include "cam_angle.h"  // cam_angle_of_pos
#include "cam_fix.h"    // cam_wrap_add
#include "cam_record.h" // cam_tick_record_t, cam_motion_t
#include <stdatomic.h>  // cam_turn_bins_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int16_t, int32_t, uint32_t

enum {
    cam_turn_bins_log2 = 7,
    cam_turn_bins_n = 1 << cam_turn_bins_log2, ///< per turn
    cam_learned_points = 256,                  ///< knots per turn of the tables
};

/// Learned values, written by the slow side, read by the interrupt. Knot i of a table is at i / 256
/// turn of the master position, knots 256 and 257 equal knots 0 and 1; linear interpolation.
typedef struct {
    int32_t k1_q16;                     ///< [ticks] added to the configured velocity feed-forward
    int32_t k2_q16;                     ///< [ticks^2] added to the acceleration feed-forward
    int32_t friction_q6;                ///< [nm / 64] feed-forward of U's friction
    int32_t chip_q32;                   ///< [1] of U's set-point, against the force of the chip
    int32_t chip_q6;                    ///< [nm / 64] against the mean of that force
    int16_t c[cam_learned_points + 2];  ///< [nm] at full amplitude, added to U's command
    int16_t d[cam_learned_points + 2];  ///< [turn / 2^23] true angle of the spindle minus that of
                                        ///< the observer
    int16_t dm[cam_learned_points + 2]; ///< [turn / 2^23] deviation seen by the encoder: d plus
                                        ///< eccentricity, subtracted before the observer
} cam_learned_t;

/// [turn / 2^32 per tick] Below this speed a turn has too many ticks for the bins even so.
enum { cam_turn_bins_least_q32 = 1 << 12 };

/// One bin: sums over its ticks, which wrap.
typedef struct {
    int32_t error_q6;  ///< [nm / 64] due set-point of U minus measured U: the following
                       ///< error with the opposite sign
    int32_t u_nm;      ///< [nm] due set-point, rounded down
    int32_t angle_q24; ///< [turn / 2^24] measured angle minus begin of the bin; without the learned
                       ///< correction, so it may be outside the bin
    int32_t n;         ///< ticks; once the means are made, the sense in which U moves, 2^20 is 1
} cam_turn_bin_t;

/// Description of a turn whose bank is closed.
typedef struct {
    uint32_t turn;                ///< number of the turn, modulo 2^24
    cam_state_t state;            ///< of all of it, where is_steady
    bool is_steady;               ///< U played the table in all of it in one state, while
                                  ///< the phase was constant
    bool is_level;                ///< amplitude and envelope were constant
    int32_t speed_q32;            ///< [turn / 2^32 per tick] at its last plan
    int32_t scale_q30;            ///< [1] amplitude * envelope at its last plan
    int32_t phase_q32;            ///< [turn / 2^32] the spindle's angle minus the table's
    int32_t z_begin_nm, z_end_nm; ///< [nm] height played in its first and last plan
    uint32_t skip;                ///< ticks left out after each that counts: 0, 1, 3 .. 63
} cam_turn_t;

/// Bins and their turns. Zero-initialised: empty. A bank counts only after the slow side has
/// cleared it, so learning begins with the first call of cam_turn_bins_take().
typedef struct {
    cam_turn_bin_t bin[2 * cam_turn_bins_n]; ///< interrupt adds, slow side clears the idle bank
    cam_turn_t now;                          ///< interrupt only: the current turn
    bool is_clean;                           ///< interrupt only: its bank was clean when it began
    cam_turn_t closed[2];                    ///< interrupt writes: the last turn of each bank
    _Atomic uint32_t closed_turn[2];         ///< interrupt writes: its number + 2^24, 0 if invalid
    _Atomic uint32_t at_q8;      ///< interrupt writes: [turn / 256] position at the last plan
    _Atomic int32_t z_vel_q10;   ///< interrupt writes: [nm / 1024 per tick] speed of Z planned last
    _Atomic uint32_t cleared[2]; ///< slow side writes: turn + 2^24 for which a bank is empty
    uint32_t taken;              ///< slow side only: turn + 2^24 that was taken last
} cam_turn_bins_t;

/// Add a tick to its bin, except where a long turn leaves it out.
static inline void cam_turn_bins_add_isr(cam_turn_bins_t *g, const cam_tick_record_t *r)
{
    if ((r->tick & g->now.skip) != 0u) {
        return;
    }
    const uint32_t low = cam_angle_of_pos(r->angle.pos_q32) >> (32 - cam_turn_bins_log2);
    const uint32_t high = (uint32_t)((uint64_t)r->angle.pos_q32 >> 32);
    const uint32_t i = low | (high & 1u) << cam_turn_bins_log2;
    // The bank bit shifts out of the word, which leaves the begin of the bin.
    const int32_t in_bin_q32 = (int32_t)(r->angle.measured_q32 - (i << (32 - cam_turn_bins_log2)));
    const uint32_t error_q6 =
        (uint32_t)r->want.u_due_q6 - 64u * (uint32_t)r->in.actual_nm[hal_axis_u];
    cam_turn_bin_t *bin = &g->bin[i];
    bin->error_q6 = (int32_t)((uint32_t)bin->error_q6 + error_q6);
    bin->u_nm = cam_wrap_add(bin->u_nm, r->want.u_due_q6 >> 6);
    bin->angle_q24 = cam_wrap_add(bin->angle_q24, in_bin_q32 >> 8);
    bin->n = cam_wrap_add(bin->n, 1);
}

/// Position of an angle between two knots.
typedef struct {
    uint32_t knot;  ///< the first one, 0 .. 255
    uint32_t share; ///< [1 / 256] weights of both knots, that of the first one in the lower half
} cam_learned_place_t;

static inline cam_learned_place_t cam_learned_place(uint32_t theta_q32)
{
    const uint32_t part_q8 = (theta_q32 >> 16) & 0xFFu;
    return (cam_learned_place_t){.knot = theta_q32 >> 24, .share = part_q8 * 0xFFFFu + 256u};
}

/// Read a table between two knots.
/// @param table  cam_learned_points + 1 knots
/// @return       2^8 times the value at the angle, which is rounded down to 2^-16 turn
static inline int32_t cam_learned_at_q8(const int16_t *table, cam_learned_place_t at)
{
    uint32_t knots = 0;
    (void)__builtin_memcpy(&knots, &table[at.knot], sizeof knots); // one load, not a call
    return cam_dot_i16(knots, at.share);
}

/// Derivative of a deviation, half a knot later.
/// @return [2^-23] share by which the spindle is faster than its mean
static inline int32_t cam_learned_faster_q23(const int16_t *table, cam_learned_place_t at)
{
    const cam_learned_place_t next = {.knot = at.knot + 1u, .share = at.share};
    return cam_wrap_sub(cam_learned_at_q8(table, next), cam_learned_at_q8(table, at));
}

/// @return [turn / 2^32] a deviation
static inline uint32_t cam_learned_turn_q32(const int16_t *table, cam_learned_place_t at)
{
    return 2u * (uint32_t)cam_learned_at_q8(table, at);
}

/// Once per plan: on a new turn, close the last one and open the new one.
void cam_turn_bins_plan_isr(cam_turn_bins_t *g, const cam_tick_record_t *r, const cam_motion_t *m);

/// Take the bank of the previous turn, once, if it holds exactly that turn; otherwise clear the
/// idle bank for the next turn. Call it at least three times a turn.
/// @param turn  result
/// @return      128 bins, bin i from i / 128 turn of the master position on, valid until
///              cam_turn_bins_release(); NULL if there is no such turn
const cam_turn_bin_t *cam_turn_bins_take(cam_turn_bins_t *g, cam_turn_t *turn);

/// Clear a bank and give it back.
/// @return false if called later than three quarters into the next turn: the data may have been
///         overwritten while it was read and must be discarded
bool cam_turn_bins_release(cam_turn_bins_t *g);

#endif
