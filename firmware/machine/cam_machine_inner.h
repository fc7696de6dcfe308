// SPDX-License-Identifier: Apache-2.0
/// cam_machine_inner: interface between the files of this room, private to it.
///
/// Requests and configurations are the bottom, on which all files stand; then what a command
/// checks, the parts of cam_machine_poll(), and the arithmetic of offsets, passes and waves.
///
/// One request and one configuration can be pending; until the interrupt has taken it, the next is
/// refused with cam_err_busy. Context: slow side, one caller.
#ifndef CAM_MACHINE_INNER_H
#define CAM_MACHINE_INNER_H

#include "cam_config.h"  // cam_config_t, cam_acknowledge_config_t
#include "cam_err.h"     // cam_err_t, cam_verdict_t
#include "cam_machine.h" // cam_machine_t, cam_offsets_t
#include "cam_motion.h"  // cam_motion_limits_t
#include "cam_param.h"   // cam_params_t, cam_refusal_t
#include "cam_table.h"   // cam_table_t
#include "cam_tick.h"    // cam_status_t
#include "hal/hal.h"     // hal_axis_t
#include <stdatomic.h>   // offered
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, int64_t, uint32_t

/// @return whether the interrupt has carried out the last request
bool cam_machine_is_carried_out(const cam_machine_t *m, const cam_status_t *status);

/// @return whether the state may be about to change: a request is not carried out, or an excitation
///         is between two steps
bool cam_machine_is_pending(const cam_machine_t *m, const cam_status_t *status);

/// Post a request unchecked. The caller has checked that the last one is carried out.
void cam_machine_request(cam_machine_t *m, cam_request_t request);

/// Post a request to the interrupt, which takes it in the next tick.
/// @return cam_ok, or cam_err_busy if cam_machine_is_pending()
CAM_MUST_USE cam_err_t cam_machine_post(cam_machine_t *m, const cam_status_t *status,
                                        cam_request_t request);

/// @return the newest configuration handed over, in force or about to be; NULL before the first
static inline const cam_config_t *cam_machine_newest_config(const cam_machine_t *m)
{
    return atomic_load_explicit(&m->core->config.offered, memory_order_relaxed);
}

/// Offer the copy from cam_config_copy(), changed, with a new generation; in force from the next
/// tick on. The rest of the configuration is not checked again. The sums of configured and learned
/// k1 and k2 must be below 2^31.
void cam_machine_offer_copy(cam_machine_t *m);

/// Hand parameters, table and learned values to the interrupt as the configuration of one pass,
/// with the parameters of cam_pass_params(). The overspeed limit is 1 % above the peak that the
/// highest feasible speed of that pass has within a turn. Nothing changes on error.
/// @param table  NULL: none
/// @param pass   that start cuts next
/// @return       cam_ok, cam_err_busy (also while a wave plays), or an error of cam_build_config(),
///               whose refusal is kept
CAM_MUST_USE cam_err_t cam_machine_hand_over(cam_machine_t *m, const cam_params_t *params,
                                             const cam_table_t *table, uint32_t pass);

/// @return the defaults of this port, with learning on where U is measured
cam_params_t cam_machine_defaults(uint32_t tick_hz);

/// Hand over the kept parameters if they are undamaged and fit the tick.
/// Context: before the tick starts.
/// @return false when nothing was handed over, see m->kept.err
bool cam_machine_load_params(cam_machine_t *m);

/// Check the inputs, that U's position loop is set, and that U is within its stroke: set-points are
/// limited to the stroke, so U would jump to its edge on enable.
/// @return cam_ok, cam_err_estop, _drive, _bus, _servo_none, _u_place
CAM_MUST_USE cam_err_t cam_machine_check_drives(const cam_params_t *params,
                                                const cam_status_t *status);

/// @return cam_ok when the button was pressed or is waived; else cam_err_acknowledge, or
///         cam_err_acknowledge_none when the port has no button
CAM_MUST_USE cam_err_t cam_machine_check_acknowledge(const cam_machine_t *m,
                                                     const cam_status_t *status);

cam_acknowledge_config_t cam_machine_acknowledge_config(const cam_machine_t *m);

/// Check whether the axes may follow the loaded table: homed where homing_required is set, and the
/// part within the known travel of X and Z.
/// @return cam_ok, cam_err_busy until a new home is in force, cam_err_not_homed, cam_err_travel
CAM_MUST_USE cam_err_t cam_machine_check_positions(const cam_machine_t *m,
                                                   const cam_status_t *status);

/// @return whether all X positions of every pass are within X's known travel: the cut, the
///         clearance and the rehearsal
/// @param x_trim_nm  [nm] the operator's trim
bool cam_machine_is_x_in_travel(const cam_machine_t *m, const cam_status_t *status,
                                int32_t x_trim_nm);

/// Check all passes at the speeds that start would use. If infeasible, record why in m->refusal.
/// @return cam_ok or a feasibility error
CAM_MUST_USE cam_err_t cam_machine_judge(cam_machine_t *m, const cam_params_t *params,
                                         const cam_table_t *table);

/// Brake the moving axis. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_jog_stop(cam_machine_t *m);

/// Stop or disable in the state identifying. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_identify_stop(cam_machine_t *m, bool disables);

/// Discard or adapt learned values that depend on a parameter that was set.
void cam_machine_unlearn(cam_machine_t *m, cam_param_id_t id);

/// Where the spindle turns more slowly, the observer follows its ripple better than 256 points do:
/// it misses (n / f)^2 of it at n turns/s and a bandwidth f, and they (2 pi / 256)^2.
/// @return [r/min / 1000] speed from which the ripple is learned: f / 32 turns per second
uint32_t cam_machine_ripple_from_mrpm(const cam_params_t *params);

/// Parts of cam_machine_poll(): stop the motion when command is lost, apply new homes, carry on an
/// excitation, and read the trace ring for recording and black box: at least every
/// cam_trace_capacity / 2 ticks while one of them is on.
void cam_machine_rights_poll(cam_machine_t *m, const cam_status_t *status);
void cam_machine_jog_poll(cam_machine_t *m);
void cam_machine_identify_poll(cam_machine_t *m);
void cam_machine_scope_poll(cam_machine_t *m);

/// Offsets: port coordinates to machine coordinates to part coordinates, for X and Z.
///
///     machine = port + shift                         from homing, 0 before
///     part    = machine + datum + tool offset
///
/// The interrupt itself shifts U. Source: MATHS.md (170). Cannot fail.

/// Parameters of an axis. Fields that do not apply to U are 0.
typedef struct {
    int32_t method; ///< of homing; 0: none needed, 1: as it stands, 2: switch, 3: switch and index,
                    ///< 4: stop, 5: stop and index
    int32_t sense;
    int32_t search_um_per_s, slow_um_per_s;
    int32_t home_nm;           ///< [nm] machine coordinate
    int32_t way_nm;            ///< [nm] longest travel of a homing phase
    int32_t low_nm, high_nm;   ///< [nm] travel, machine coordinates; equal: no limits
    int32_t datum_nm, tool_nm; ///< [nm] datum, and offset of the selected tool
} cam_offsets_axis_t;

cam_offsets_axis_t cam_offsets_axis(const cam_params_t *params, hal_axis_t axis);

/// @return [nm] machine coordinate minus port coordinate; 0 for U
int32_t cam_offsets_shift_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// [nm] travel to either side of an axis without limits; readings beyond 2^30 nm are refused.
#define CAM_OFFSETS_FAR_NM 1000000000

/// Travel of an axis, in port coordinates.
typedef struct {
    int32_t low_nm, high_nm;
} cam_offsets_travel_t;

/// @param axis      X or Z
/// @param is_known  whether its position is known; otherwise the limits do not apply
cam_offsets_travel_t cam_offsets_travel(const cam_offsets_t *h, const cam_params_t *params,
                                        hal_axis_t axis, bool is_known);

/// @return the pass after pass i: after the last the first; always cam_pass_first() where the
///         parameter `pass` is set
uint32_t cam_pass_next(const cam_params_t *params, const cam_table_t *table, uint32_t i);

/// Check all passes, each at its own speed.
/// @return no refusal, or that of the first infeasible pass, as cam_pass_feasibility()
cam_refusal_t cam_pass_check(const cam_table_t *table, const cam_params_t *params,
                             uint32_t tick_hz);

/// Check pass i, with the details of cam_feasible().
cam_refusal_t cam_pass_feasibility(const cam_table_t *table, const cam_params_t *params,
                                   uint32_t tick_hz, uint32_t i);

/// @return [r/min / 1000] highest speed feasible for all passes; 0: none
uint32_t cam_pass_highest_mrpm(const cam_table_t *table, const cam_params_t *params,
                               uint32_t tick_hz);

/// Waves: check of an excitation of U against U's limits. A periodic wave w is played with a gain
/// g <= 1 of at most g1 per tick and g2 per tick^2. The product stays within |w|, its speed within
/// max |dw| + g1 max |w|, its acceleration within max |d2w| + 2 g1 max |dw| + g2 max |w|, with the
/// differences across the wrap. A wave of force stays within the force limit, whatever the gain.

enum {
    cam_wave_least = 16,           ///< [ticks] shortest period, shortest fade
    cam_wave_longest_fade = 65535, ///< [ticks]
    cam_wave_longest_s = 60,       ///< [s] fade and periods together
};

/// Range, speed and acceleration of a wave; of a wave of force mN take the place of nm.
typedef struct {
    int64_t low_nm, high_nm; ///< [nm] least and largest of the samples and 0
    int64_t step_nm;         ///< [nm per tick] largest difference of neighbours
    int64_t bend_nm;         ///< [nm per tick^2] largest second difference
} cam_wave_range_t;

/// @param wave_nm  [nm], or [mN] of force
/// @param n        samples, at least 2
cam_wave_range_t cam_wave_range(const int32_t *wave_nm, uint32_t n);

/// @param fade_ticks  [ticks] cam_wave_least .. cam_wave_longest_fade
/// @return            limits of a gain that rises from 0 to 1 in this time, or in up to a quarter
///                    less for a long fade; cam_wave_fall_ticks() counts the ticks
cam_motion_limits_t cam_wave_fade(uint32_t fade_ticks);

/// @return [ticks] in which the gain falls from 1 to 0, without the last tick, at rest
/// Context: takes one step of cam_move_profile_to_isr() per tick.
uint32_t cam_wave_fall_ticks(const cam_motion_limits_t *fade);

/// @return [nm] largest distance of a sample from 0
int64_t cam_wave_peak_nm(const cam_wave_range_t *range);

/// Check stroke, speed and acceleration of U; of a wave of force that force, and U's mean position.
/// @param is_force  the range is in mN
/// @param place_nm  [nm] U's mean position
/// @param cfg       configuration in force
/// @return          cam_ok, or a demand above its limit: cam_err_wave_stroke with the position [nm]
///                  farthest from 0, _wave_speed [um/s], _wave_acceleration [mm/s2],
///                  _wave_force [mN]
cam_verdict_t cam_wave_judge(const cam_wave_range_t *range, const cam_motion_limits_t *fade,
                             bool is_force, int32_t place_nm, const cam_config_t *cfg,
                             uint32_t tick_hz);

#endif
