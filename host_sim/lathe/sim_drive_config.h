// SPDX-License-Identifier: Apache-2.0
/// sim_drive_config: what a machine file says of a drive; units as in sim_drive.h.
#ifndef SIM_DRIVE_CONFIG_H
#define SIM_DRIVE_CONFIG_H

#include <stdint.h> // uint32_t

#define SIM_DRIVE_MICRO_PER_M 1e9 ///< millionths of the unit of a slide, the millimetre, in a metre

typedef enum {
    sim_drive_position, ///< takes positions, a closed loop of its own
    sim_drive_force,    ///< takes forces: a mass, its amplifier and the loop of sim_servo.h
} sim_drive_kind_t;

typedef struct {
    double bandwidth_hz;              ///< w / 2 pi
    double damping;                   ///< d
    double delay_us;                  ///< D, from the write of the command to its effect
    double quantum_micro;             ///< of command and measurement; 0: none
    double speed_units_per_s;         ///< v_max
    double acceleration_units_per_s2; ///< a_max; of kind force the limit is force_limit_n
    double command_quantum_micro;     ///< of the command alone, 0: quantum_micro
    // slides in millimetres only
    double friction_m_per_s2; ///< Coulomb friction by mass; 0: none
    double mass_kg;           ///< what a force accelerates; 0: forces have no effect
    // kind force
    double viscous_n_s_per_m;
    double stiffness_n_per_m;
    double force_limit_n;
    double amplifier_hz;  ///< corner of the current loop
    double tuned_mass_kg; ///< that the position loop is tuned for
    uint32_t kind;        ///< sim_drive_kind_t
    uint32_t reserved;    ///< 0
} sim_drive_config_t;

#endif
