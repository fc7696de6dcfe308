// SPDX-License-Identifier: Apache-2.0
/// sim_lathe: spindle, encoder and four drives: the same lathe for every controller.
///
/// The lathe knows only set-points and time: port/sim_port.h connects it to the firmware in this
/// process, bus/sim_bus.h to the nodes of a CAN bus. Convention: turn is the drawing's angle at the
/// tool (PARTFILE.md). It rises in the machine's positive sense (M3), the sense of a positive
/// spindle set-point.
///
/// The position of U's tip is its slide plus the motion of the modes and the bending by the chip.
/// The scale of U measures the slide and the modes that act on the scale. The run-out of the
/// spindle moves the part: runout cos(2 pi turn) + runout_2 cos(4 pi turn) are added to X, the
/// distance of the tool from the axis, MATHS.md (128).
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

/// Contents of a machine file; sim_drive.h explains the units of the drives.
typedef struct {
    double tick_hz; ///< of the controller
    sim_spindle_config_t spindle;
    sim_encoder_config_t encoder;
    sim_drive_config_t drive[sim_lathe_n_drives]; ///< speed 0 of the swing: the machine has none
    sim_home_config_t home[hal_n_axes];
    double swing_range_deg;             ///< travel of the swing to either side
    sim_mode_config_t mode[sim_mode_n]; ///< of U
    sim_scale_config_t scale;           ///< of U
    sim_chip_config_t chip;             ///< of a skirt's tool
    double runout_um, runout_2_um; ///< run-out of the spindle once and twice per turn, amplitudes
    double u_stroke_mm;            ///< travel of U peak to peak, centred on 0
    double spindle_limit_rpm;      ///< highest speed of the spindle
    double x_start_mm;             ///< X at the start, above the blank's radius
    double z_start_mm;             ///< Z at the start, before the part's first height
    double tool_nose_mm;           ///< radius of the nose, 0: a point, below 0: that of the table
    double tool_wear_um;           ///< wear of the tip
    double wheel_wear_um;          ///< wear of a wheel's radius per lobe
} sim_lathe_config_t;

/// 20 kHz, the defaults of all models, U 1.2 mm, 3000 r/min, X 2 mm off the blank, Z 2 mm before
/// the part.
sim_lathe_config_t sim_lathe_defaults(void);

/// Set-points of the controller for one step.
typedef struct {
    double spindle_rad_per_s;
    double force_n;                      ///< of U, where it takes forces
    int32_t micro[sim_lathe_n_drives];   ///< positions: nm of the axes, micro-degrees of the swing
    bool is_enabled[sim_lathe_n_drives]; ///< false: the drive brakes to rest and holds
} sim_setpoints_t;

/// The true state at an instant.
typedef struct {
    double t_s;
    double turn;             ///< [turn] angle of the spindle, not wrapped
    double u_nm, x_nm, z_nm; ///< tool tip; X includes the spindle's run-out
    double swing_deg; ///< angle of the tool about the swing's centre, 0 along the line of centres
} sim_sample_t;

typedef struct {
    double step_s;
    sim_spindle_t spindle;
    sim_encoder_t encoder;
    sim_drive_t drive[sim_lathe_n_drives];
    sim_mode_t mode[sim_mode_n];
    sim_scale_t scale;
    sim_chip_config_t chip;
    bool is_scale_ideal; ///< U has no modes, and its scale neither latency nor error
    double runout_nm, runout_2_nm;
    double chip_n;   ///< present radial cutting force
    double unread_s; ///< time since the last reading of the encoder
    // injected faults
    bool is_scale_stuck;    ///< the scale of U shows stuck_micro
    int32_t stuck_micro;    ///< reading at the moment it stuck
    bool is_force_reversed; ///< the force of U acts against its command
    double push_n;          ///< force on U besides that of the chip
    bool is_speed_forced;   ///< the spindle runs at forced_rad_per_s, whatever is commanded
    double forced_rad_per_s;
    bool is_reversed;           ///< the spindle turns against its set-point
    uint32_t count_offset;      ///< [counts] added to the counter and to the index latch
    bool is_encoder_stuck;      ///< the counter keeps stuck_counts
    bool is_index_dead;         ///< no index edge arrives any more
    uint32_t stuck_counts;      ///< counter at the moment it stuck
    hal_encoder_t last_index;   ///< reading at the moment the index died
    hal_encoder_t true_reading; ///< last reading without the faults
} sim_lathe_t;

/// Start with the lathe at rest.
/// @param l       39 KB
/// @param step_s  time between two set-points
/// @param x_nm, z_nm  positions at the start
/// @param seed    seed of all noise
void sim_lathe_init(sim_lathe_t *l, const sim_lathe_config_t *config, double step_s, double x_nm,
                    double z_nm, uint64_t seed);

/// Apply set-points and advance by one step.
void sim_lathe_step(sim_lathe_t *l, const sim_setpoints_t *set);

/// Likewise for another time than a step: set-points that come early, or another clock.
/// @param dt_s  above 0; sim_lathe_step() is faster for a nominal step
void sim_lathe_step_in(sim_lathe_t *l, const sim_setpoints_t *set, double dt_s);

/// Advance with the present set-points, because the next ones are late. The delay lines of the
/// drives are held meanwhile, so commands take effect later by the same amount.
void sim_lathe_linger(sim_lathe_t *l, const sim_setpoints_t *set, double late_s);

/// Set the depth of the skirt's tool in the blank: the cutting force acts from now on.
/// @param depth_mm  0 or below: clear of the blank
void sim_lathe_bite(sim_lathe_t *l, double depth_mm);

/// @return the position that a drive's scale shows, in micro
int32_t sim_lathe_measured_micro(const sim_lathe_t *l, int drive);

/// Read the encoder with its faults. At most one turn may pass between two readings.
hal_encoder_t sim_lathe_encoder(sim_lathe_t *l);

/// Stop the counter.
void sim_lathe_stick_encoder(sim_lathe_t *l);

/// Stop reporting index edges.
void sim_lathe_kill_index(sim_lathe_t *l);

/// @param t_s  [s] controller's clock
sim_sample_t sim_lathe_sample(const sim_lathe_t *l, double t_s);

/// @return true when a drive is slower than 1 um/s
bool sim_lathe_drive_rests(const sim_lathe_t *l, int drive);

/// @return true when the spindle is slower than 0.01 rad/s
bool sim_lathe_spindle_rests(const sim_lathe_t *l);

#endif
