// SPDX-License-Identifier: Apache-2.0
/// sim_machine: spindle, encoder and four drives around the simulator's port.
///
/// Time advances in ticks. At the start of a tick the true state is put into hal_host.in; the
/// firmware runs; the drives take what it wrote and everything moves on by one period. Convention:
/// turn 0 is the long axis, positive turn is the machine's positive sense, into which a positive
/// spindle set-point turns.
///
///     sense: models -> hal_host.in     tick (sim_firmware.h)     advance: hal_host.out -> models
///
/// Between the first and the last the true state is that of the instant of sensing.
#ifndef SIM_MACHINE_H
#define SIM_MACHINE_H

#include "sim_drive.h"   // sim_drive_t
#include "sim_encoder.h" // sim_encoder_t
#include "sim_spindle.h" // sim_spindle_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t, uint64_t

/// What a machine file describes; units in the names.
typedef struct {
    double tick_hz;
    sim_spindle_config_t spindle;
    sim_encoder_config_t encoder;
    sim_drive_config_t axis[3]; ///< U, X, Z in the order of hal_axis_t
    sim_drive_config_t swing;   ///< degrees for millimetres; speed 0: the machine has none
    double swing_range_deg;     ///< travel of the swing to either side
    double u_stroke_mm;         ///< travel of U peak to peak, centred on 0
    double spindle_limit_rpm;   ///< highest speed of the spindle
    double x_start_mm;          ///< X at the start, above the blank's radius
    double z_start_mm;          ///< Z at the start, before the part's first height
} sim_machine_config_t;

/// 20 kHz, the defaults of all models, U 1.2 mm, 3000 r/min, X 2 mm off the blank, Z 2 mm before
/// the part.
sim_machine_config_t sim_machine_defaults(void);

typedef struct {
    double period_s;
    double time_s;
    sim_spindle_t spindle;
    sim_encoder_t encoder;
    sim_drive_t axis[3];
    sim_drive_t swing;     ///< [1e-6 degrees] for nanometres
    uint32_t n_swing;      ///< set-points of the swing that were taken
    int32_t swing_set_q32; ///< [turn / 2^32] set-point in force
    bool is_speed_forced;  ///< the spindle runs as it likes
    double forced_rad_per_s;
    bool is_reversed;    ///< the spindle turns against its set-point
    int32_t z_offset_nm; ///< added to the measured Z
    double late_s;       ///< the next tick comes later by this
    double lost_s;       ///< sum of what late ticks came late
} sim_machine_t;

/// Bring the machine to rest and reset the port.
/// @param m      41 KB
/// @param x_nm, z_nm  places at the start
/// @param seed   of all noise
void sim_machine_init(sim_machine_t *m, const sim_machine_config_t *config, double x_nm,
                      double z_nm, uint64_t seed);

/// Before a tick: what the firmware will sense.
void sim_machine_sense(sim_machine_t *m);

/// After it: let one period pass.
void sim_machine_advance(sim_machine_t *m);

/// The next tick comes late. The models live through the longer time; within it the dead time of
/// the drives is held, so a command takes effect later by the same amount.
/// @param percent  of a period
void sim_machine_late(sim_machine_t *m, double percent);

/// @return [mm] radius at which the tool tip is: X - U
static inline double sim_machine_radius_mm(const sim_machine_t *m)
{
    return (m->axis[hal_axis_x].pos_nm - m->axis[hal_axis_u].pos_nm) * 1e-6;
}

/// @return [degrees] true swing of the tool about the swing's centre, 0 along the line of centres
static inline double sim_machine_swing_deg(const sim_machine_t *m)
{
    return m->swing.pos_nm * 1e-6;
}

/// @return [degrees] set-point of the swing in the last tick
static inline double sim_machine_swing_set_deg(const sim_machine_t *m)
{
    return m->swing_set_q32 * (360.0 / 4294967296.0);
}

/// @return [mm] true height of the tool tip
static inline double sim_machine_z_mm(const sim_machine_t *m)
{
    return m->axis[hal_axis_z].pos_nm * 1e-6;
}

#endif
