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
/// With Coulomb friction or an external force, the slide below moves instead, piece by
/// piece; without them the result is the exact one above, bit for bit. A drive of kind force is a
/// bare mass that takes forces, limited to the greatest one; its dead time is between the command
/// and the amplifier. While it is disabled a brake stops it within the limit of its acceleration.
#ifndef SIM_DRIVE_H
#define SIM_DRIVE_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t, int32_t

// A slide with stick-slip, driven by a drive and disturbed by a force.
//
//     d2x/dt2 = clamp(p - K x - D v, -A, A) + a - f sgn(v)       while it moves
//     v = 0 and stays 0                                          while |p - K x + a| <= f
//     dp/dt = (input - p) / tau, or p = input where tau = 0
//
// K and D belong to a position loop (w^2, 2 d w; the input is w^2 times the command) or to the
// guide of a free mass (spring and drag per mass; the input is force per mass). f is the Coulomb
// friction per mass, the same at rest and in motion. Source: MATHS.md (121), (122); Coulomb's law
// as in Armstrong-Helouvry, Dupont, Canudas de Wit, "A survey of models, analysis tools and
// compensation methods for the control of machines with friction", Automatica 30(7), 1994.
//
// Beyond a stop, its spring and a damper of half the critical damping push the slide back.
//
// The sign function is not regularised: a reversal is located to 2^-40 of a sub-step. The slide
// rests there and moves again only when the push exceeds the friction, so sticking is true rest.
//
// Discretisation: classical fourth-order Runge-Kutta, at least 4 sub-steps in a piece of constant
// input, none longer than a quarter of the fastest time constant. With 300 Hz, damping 0.7 and 20
// kHz the relative error of the travel is below 5e-9 where the sign of v does not change;
// breakaway is found to a sub-step, 6 us, during which the net push grows from zero. Compared with
// an event-driven solution of scipy at 20 m/s2 and 100 Hz the error is below 0.05 nm
// (tests/tools/sim/test_slide.py). At the limits of acceleration (A) and speed the error is of
// second order in the sub-step.

/// Units: micro and seconds, as above.
typedef struct {
    double stiffness_per_s2;          ///< K
    double drag_per_s;                ///< D
    double acceleration_micro_per_s2; ///< A, > 0
    double speed_micro_per_s;         ///< limit of |v|, > 0
    double friction_micro_per_s2;     ///< f
    double lag_per_s;                 ///< 1 / tau, 0: none
    double stop_micro;                ///< stops at this distance from 0, either side; 0: none
    double stop_per_s2;               ///< their stiffness per mass, > 0
    double longest_s;                 ///< longest sub-step, see sim_friction_longest_s()
} sim_friction_law_t;

typedef struct {
    double pos_micro;
    double vel_micro_per_s;
    double push_micro_per_s2; ///< p
} sim_friction_state_t;

/// @return [s] longest sub-step allowed by the constants of a law; does not read law->longest_s
double sim_friction_longest_s(const sim_friction_law_t *law);

/// Advance with a constant input.
/// @param input_micro_per_s2    input of the push
/// @param disturb_micro_per_s2  a, constant
/// @param time_s                >= 0
void sim_friction_move(const sim_friction_law_t *law, sim_friction_state_t *s,
                       double input_micro_per_s2, double disturb_micro_per_s2, double time_s);

// A drive in a machine file; units as above.

#define SIM_DRIVE_MICRO_PER_M 1e9 ///< nanometres, the millionths of a slide's unit, in a metre

typedef enum {
    sim_drive_position, ///< takes positions; a closed loop of its own
    sim_drive_force,    ///< takes forces: a mass and an amplifier
} sim_drive_kind_t;

typedef struct {
    double bandwidth_hz;              ///< w / 2 pi
    double damping;                   ///< d
    double delay_us;                  ///< D, from the write of the command to its effect
    double quantum_micro;             ///< of command and measurement; 0: none
    double speed_units_per_s;         ///< v_max
    double acceleration_units_per_s2; ///< a_max; kind force has force_limit_n instead
    double command_quantum_micro;     ///< of the command alone, 0: quantum_micro
    double is_relative;               ///< 1: the command at enable is where the drive stands then
    // slides in millimetres only
    double friction_m_per_s2; ///< Coulomb friction per mass; 0: none
    double mass_kg;           ///< moved mass; 0: forces have no effect
    // kind force
    double viscous_n_s_per_m;
    double stiffness_n_per_m;
    double force_limit_n;
    double force_quantum_n; ///< step of the amplifier's input
    double amplifier_hz;    ///< corner of the current loop
    double stop_units;      ///< stops at this distance from 0, either side; 0: none
    double stop_n_per_um;   ///< their stiffness
    uint32_t kind;          ///< sim_drive_kind_t
    uint32_t reserved;      ///< 0
} sim_drive_config_t;

// The drive

#define SIM_MICRO 1e6 ///< millionths in a unit

enum { sim_drive_ring = 1024, sim_drive_max_delay_ticks = sim_drive_ring - 2 };

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
