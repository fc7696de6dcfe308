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
/// Units: the model serves slides and the swing of the tool. One unit is a millimetre of a slide
/// and a degree of the swing; positions, commands and speeds are held in millionths of it
/// ("micro"), so 250 is 250 nm of a slide and 250 micro-degrees of the swing.
///
/// Discretisation: between two changes of the command the matrix exponential is exact; a dead time
/// that is no whole number of steps splits the step in two such pieces, exact too. A piece that
/// meets a limit is redone in 16 sub-steps of constant acceleration: with the acceleration at its
/// limit this is exact again, otherwise it is off by less than (w T / 16)^2 / 3 of the distance
/// travelled in the piece (4e-5 for 300 Hz at 20 kHz). The limits are checked at the ends of a
/// piece.
///
/// A drive with Coulomb friction, or one that a force disturbs, is moved by sim_friction.h instead,
/// piece by piece; without both it takes the exact way above, bit for bit. A drive of kind force is
/// a mass under the loop of sim_servo.h; its dead time lies between force command and amplifier.
#ifndef SIM_DRIVE_H
#define SIM_DRIVE_H

#include "sim_drive_config.h" // sim_drive_config_t
#include "sim_friction.h"     // sim_friction_law_t
#include "sim_servo.h"        // sim_servo_t
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
    double middle_s;          ///< time of it after the step's begin; 0: it changed there
    double stiffness_per_s2;  ///< w^2
    double drag_per_s;        ///< 2 d w
    double speed_micro_per_s; ///< limits
    double acceleration_micro_per_s2;
    double quantum_micro, per_quantum_micro;
    double command_quantum_micro;
    double period_s;
    bool is_force;                 ///< of kind force
    sim_servo_t servo;             ///< then
    double push_micro_per_s2;      ///< what its amplifier puts out by mass, then
    sim_friction_law_t law;        ///< of sub-steps: friction, an outer force, kind force
    double disturb_micro_per_s2;   ///< acceleration by the outer force
    double per_force_micro_per_s2; ///< [micro/s2 per N]
    double beyond_micro;           ///< what the scale sees beside the slide itself
    sim_drive_flow_t before;       ///< the piece before the delayed command changes
    sim_drive_flow_t after;        ///< the piece after that
    bool is_split;    ///< the dead time is no whole number of steps: `before` takes time
    bool is_blocked;  ///< the axis stands still whatever is commanded
    uint32_t n_delay; ///< whole steps of dead time
    uint32_t i_command;
    double command_micro[sim_drive_ring]; ///< kind force: of force by mass, micro/s2
} sim_drive_t;

/// @param start_micro  position at rest before the start; earlier commands are taken to be the same
/// @param period_s     time between two commands; delay / period <= sim_drive_max_delay_ticks
void sim_drive_init(sim_drive_t *d, const sim_drive_config_t *config, double start_micro,
                    double period_s);

/// Take a command and let one period pass.
/// @param is_enabled  false: the drive brakes to rest within its limits and holds
void sim_drive_step(sim_drive_t *d, int32_t command_micro, bool is_enabled);

/// Likewise in another time than a period. The dead time keeps its whole periods.
/// @param dt_s  above 0; slower than a step
void sim_drive_step_in(sim_drive_t *d, int32_t command_micro, bool is_enabled, double dt_s);

/// An outer force acts on the slide from now on.
/// @param force_n  signed, constant over the coming step; nothing without a mass
void sim_drive_disturb(sim_drive_t *d, double force_n);

/// Let more time pass with the last effective command, because the next one comes late.
/// @param dt_s  >= 0, any; slower than a step
void sim_drive_linger(sim_drive_t *d, double dt_s, bool is_enabled);

/// @return a position as the drive reports it, rounded to the quantum
int32_t sim_drive_reported_micro(const sim_drive_t *d, double micro);

/// @return the position that the drive reports
int32_t sim_drive_measured_micro(const sim_drive_t *d);

/// @return the exact flow of the second-order system without limits over time_s
sim_drive_flow_t sim_drive_flow(double omega_rad_per_s, double damping, double time_s);

#endif
