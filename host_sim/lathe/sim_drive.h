// SPDX-License-Identifier: Apache-2.0
/// sim_drive: a position-controlled axis: quantum, dead time, second order, limits.
///
///     d2y/dt2 = w^2 (c(t - D) - y) - 2 d w dy/dt,   |dy/dt| <= v_max,  |d2y/dt2| <= a_max
///
/// c is the command, held from step to step and rounded to the quantum; the measured position is
/// rounded likewise. Source: MATHS.md (68), the usual model of a closed loop, e.g. Franklin,
/// Powell, Workman, "Digital Control of Dynamic Systems", 3rd ed., 4.3 (zero-order hold) and 4.3.4
/// (delay).
///
/// Units: a unit is a millimetre for slides and a degree for the swing of the tool. Positions,
/// commands and speeds are in millionths of it ("micro"), so 250 is 250 nm or 250 micro-degrees.
///
/// Discretisation: between two changes of the command the matrix exponential is exact; a dead time
/// that is not a whole number of steps splits the step into two exact pieces. A piece that meets a
/// limit is repeated in 16 sub-steps of constant acceleration: exact with the acceleration at its
/// limit, otherwise with an error below (w T / 16)^2 / 3 of the distance travelled in the piece
/// (4e-5 for 300 Hz at 20 kHz). The limits are checked at the ends of a piece.
///
/// With Coulomb friction or an external force, sim_friction.h moves the drive instead, piece by
/// piece; without them the result is the exact one above, bit for bit. A drive of kind force is a
/// bare mass that takes forces, limited to the greatest one; its dead time is between the command
/// and the amplifier. While it is disabled a brake stops it within the limit of its acceleration.
#ifndef SIM_DRIVE_H
#define SIM_DRIVE_H

#include "sim_drive_config.h" // sim_drive_config_t
#include "sim_friction.h"     // sim_friction_law_t
#include <stdbool.h>          // bool
#include <stdint.h>           // int32_t, uint32_t

#define SIM_MICRO 1e6 ///< millionths in a unit

enum { sim_drive_ring = 1024, sim_drive_max_delay_ticks = sim_drive_ring - 2 };

/// U: 300 Hz, damping 0.7, 75 us, 10 nm, 400 mm/s, 250 m/s2.
sim_drive_config_t sim_drive_u_defaults(void);

/// X and Z: 50 Hz, damping 1, no dead time, 10 nm, 100 or 200 mm/s, 2 m/s2.
sim_drive_config_t sim_drive_x_defaults(void);
sim_drive_config_t sim_drive_z_defaults(void);

/// The swing of the tool: 200 Hz, damping 0.7, 100 us, 1e-4 degrees, 1000 degrees/s,
/// 100 000 degrees/s2.
sim_drive_config_t sim_drive_swing_defaults(void);

/// The 2 x 2 matrix that takes (position - command, speed) over a piece of constant command.
typedef struct {
    double pp, pv, vp, vv;
    double time_s;
} sim_drive_flow_t;

typedef struct {
    double pos_micro, vel_micro_per_s;
} sim_drive_place_t;

typedef struct {
    double pos_micro;
    double vel_micro_per_s;
    sim_drive_place_t middle; ///< in the last step, where the delayed command changed
    double middle_s;          ///< time from the start of the step to it; 0: changed at the start
    double stiffness_per_s2;  ///< w^2
    double drag_per_s;        ///< 2 d w
    double speed_micro_per_s; ///< limits
    double acceleration_micro_per_s2;
    double quantum_micro, per_quantum_micro;
    double command_quantum_micro;
    double period_s;
    bool is_force;                 ///< of kind force
    bool is_relative;              ///< commands count from the one at enable
    bool was_enabled;              ///< in the last step
    double origin_micro;           ///< where the command 0 is
    double force_n, force_limit_n; ///< kind force: command
    double push_micro_per_s2;      ///< kind force: output of the amplifier per mass
    sim_friction_law_t law;        ///< for sub-steps: friction, external force, kind force
    double disturb_micro_per_s2;   ///< acceleration by the external force
    double per_force_micro_per_s2; ///< [micro/s2 per N]
    sim_drive_flow_t before;       ///< the piece before the delayed command changes
    sim_drive_flow_t after;        ///< the piece after it
    bool is_split;    ///< the dead time is not a whole number of steps: `before` takes time
    bool is_blocked;  ///< the axis ignores commands and does not move
    uint32_t n_delay; ///< whole steps of dead time
    uint32_t i_command;
    double command_micro[sim_drive_ring]; ///< kind force: force per mass, micro/s2
} sim_drive_t;

/// @param start_micro  position at rest before the start, and earlier commands
/// @param period_s     time between two commands; delay / period <= sim_drive_max_delay_ticks
void sim_drive_init(sim_drive_t *d, const sim_drive_config_t *config, double start_micro,
                    double period_s);

/// Apply a command and advance by one period. A drive of kind force ignores the position.
/// @param is_enabled  false: the drive brakes to rest within its limits and holds
void sim_drive_step(sim_drive_t *d, int32_t command_micro, bool is_enabled);

/// Likewise for another time than a period. The delay line still moves by one period.
/// @param dt_s  above 0; slower than sim_drive_step()
void sim_drive_step_in(sim_drive_t *d, int32_t command_micro, bool is_enabled, double dt_s);

/// Set the force that the next steps command.
/// @param force_n  positive: towards greater positions
static inline void sim_drive_push(sim_drive_t *d, double force_n)
{
    d->force_n = force_n;
}

/// Apply an external force to the slide.
/// @param force_n  signed, constant over the next step; no effect without a mass
void sim_drive_disturb(sim_drive_t *d, double force_n);

/// Advance with the last effective command, because the next one is late.
/// @param dt_s  >= 0; slower than sim_drive_step()
void sim_drive_linger(sim_drive_t *d, double dt_s, bool is_enabled);

/// @return a position, rounded to the drive's quantum
int32_t sim_drive_reported_micro(const sim_drive_t *d, double micro);

/// @return the reported position
int32_t sim_drive_measured_micro(const sim_drive_t *d);

/// @return the exact flow of the second-order system without limits over time_s
sim_drive_flow_t sim_drive_flow(double omega_rad_per_s, double damping, double time_s);

#endif
