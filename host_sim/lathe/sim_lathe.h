// SPDX-License-Identifier: Apache-2.0
/// sim_lathe: spindle, encoder and four drives: the one lathe behind every controller.
///
/// The lathe knows set-points and time, neither ports nor frames: target/sim_port.h ties it to the
/// firmware of this process, bus/sim_bus.h to the nodes of a CAN bus. Convention: turn is the
/// drawing's angle before the tool (tools/README.md), which rises in the machine's positive sense
/// (M3), into which a positive set-point of the spindle turns.
///
/// The tip of U's tool is where its slide is, and what the modes move it and the chip bends it. The
/// scale of U sees the slide and those modes that lie on it. The run-out of the spindle moves the
/// part: runout cos(2 pi turn) + runout_2 cos(4 pi turn) are added to X, the distance of the tool
/// from the axis, MATHS.md (128).
#ifndef SIM_LATHE_H
#define SIM_LATHE_H

#include "hal/hal.h"     // hal_axis_t
#include "sim_chip.h"    // sim_chip_config_t
#include "sim_drive.h"   // sim_drive_t
#include "sim_encoder.h" // sim_encoder_t
#include "sim_home.h"    // sim_home_config_t
#include "sim_mode.h"    // sim_mode_t
#include "sim_scale.h"   // sim_scale_t
#include "sim_spindle.h" // sim_spindle_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, uint32_t, uint64_t

/// Drives: the axes in the order of hal_axis_t, then the swing of the tool.
enum { sim_lathe_swing = hal_n_axes, sim_lathe_n_drives };

/// What a machine file describes; units in the names, those of the drives in sim_drive.h.
typedef struct {
    double tick_hz; ///< of the controller
    sim_spindle_config_t spindle;
    sim_encoder_config_t encoder;
    sim_drive_config_t drive[sim_lathe_n_drives]; ///< swing of speed 0: the machine has none
    sim_home_config_t home[hal_n_axes];
    double swing_range_deg;             ///< travel of the swing to either side
    sim_mode_config_t mode[sim_mode_n]; ///< of U
    sim_scale_config_t scale;           ///< of U
    sim_chip_config_t chip;             ///< of a skirt's tool
    double runout_um, runout_2_um;      ///< of the spindle once and twice per turn: amplitudes
    double u_stroke_mm;                 ///< travel of U peak to peak, centred on 0
    double spindle_limit_rpm;           ///< highest speed of the spindle
    double x_start_mm;                  ///< X at the start, above the blank's radius
    double z_start_mm;                  ///< Z at the start, before the part's first height
    double tool_nose_mm;  ///< radius of the nose, 0: a point, below 0: what the table was made for
    double tool_wear_um;  ///< by so much the tip stands back
    double wheel_wear_um; ///< radius that a wheel loses by every lobe
} sim_lathe_config_t;

/// 20 kHz, the defaults of all models, U 1.2 mm, 3000 r/min, X 2 mm off the blank, Z 2 mm before
/// the part.
sim_lathe_config_t sim_lathe_defaults(void);

/// @return whether U or spindle have an effect that a controller has to learn or to put up with:
///         friction, force, modes, the scale's own errors, cutting force, a second ripple, run-out
bool sim_lathe_is_rough(const sim_lathe_config_t *config);

/// What a controller commands for one step.
typedef struct {
    double spindle_rad_per_s;
    int32_t micro[sim_lathe_n_drives];   ///< positions: nm of the axes, micro-degrees of the swing
    bool is_enabled[sim_lathe_n_drives]; ///< false: the drive brakes to rest and holds
} sim_setpoints_t;

/// The true state at an instant.
typedef struct {
    double t_s;
    double turn;             ///< [turn] angle of the spindle, not wrapped
    double u_nm, x_nm, z_nm; ///< of the tool's tip; X with the run-out of the spindle
    double swing_deg;        ///< of the tool about the swing's centre, 0 along the line of centres
} sim_sample_t;

typedef struct {
    double step_s;
    sim_spindle_t spindle;
    sim_encoder_t encoder;
    sim_drive_t drive[sim_lathe_n_drives];
    sim_mode_t mode[sim_mode_n];
    sim_scale_t scale;
    sim_chip_config_t chip;
    double runout_nm, runout_2_nm;
    double chip_n;   ///< radial force of the cut now
    double unread_s; ///< time since the last reading of the encoder
    // faults that were caused
    bool is_speed_forced; ///< the spindle runs at forced_rad_per_s, whatever is commanded
    double forced_rad_per_s;
    bool is_reversed;           ///< the spindle turns against its set-point
    uint32_t count_offset;      ///< [counts] added to the counter and to what latches it
    bool is_encoder_stuck;      ///< the counter keeps stuck_counts
    bool is_index_dead;         ///< no index edge arrives any more
    uint32_t stuck_counts;      ///< counter when it got stuck
    hal_encoder_t last_index;   ///< reading when the index died
    hal_encoder_t true_reading; ///< last reading without the faults
} sim_lathe_t;

/// Bring the lathe to rest.
/// @param l       39 KB
/// @param step_s  time between two set-points
/// @param x_nm, z_nm  positions at the start
/// @param seed    of all noise
void sim_lathe_init(sim_lathe_t *l, const sim_lathe_config_t *config, double step_s, double x_nm,
                    double z_nm, uint64_t seed);

/// Take set-points and let one step pass.
void sim_lathe_step(sim_lathe_t *l, const sim_setpoints_t *set);

/// Likewise in another time than a step, because the next set-points come early, or by another
/// clock.
/// @param dt_s  above 0; sim_lathe_step() for a step as it is, else slower
void sim_lathe_step_in(sim_lathe_t *l, const sim_setpoints_t *set, double dt_s);

/// Let more time pass with the set-points in force, because the next ones come late. The dead time
/// of the drives is held meanwhile, so a command takes effect later by the same amount.
void sim_lathe_linger(sim_lathe_t *l, const sim_setpoints_t *set, double late_s);

/// The tip of a skirt's tool stands in the blank: the force of the chip acts from now on.
/// @param depth_mm  at most 0: clear
void sim_lathe_bite(sim_lathe_t *l, double depth_mm);

/// @return the position that a drive's scale shows, micro
int32_t sim_lathe_measured_micro(const sim_lathe_t *l, int drive);

/// Read the encoder with its faults. At most one turn may pass between two readings.
hal_encoder_t sim_lathe_encoder(sim_lathe_t *l);

/// The counter stands still from now on.
void sim_lathe_stick_encoder(sim_lathe_t *l);

/// No further index edges are reported from now on.
void sim_lathe_kill_index(sim_lathe_t *l);

/// @param t_s  [s] time of the controller's clock
sim_sample_t sim_lathe_sample(const sim_lathe_t *l, double t_s);

/// @return true when a drive is slower than 1 um/s
bool sim_lathe_drive_rests(const sim_lathe_t *l, int drive);

/// @return true when the spindle is slower than 0.01 rad/s
bool sim_lathe_spindle_rests(const sim_lathe_t *l);

#endif
