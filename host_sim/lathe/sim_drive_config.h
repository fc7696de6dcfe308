// SPDX-License-Identifier: Apache-2.0
/// sim_drive_config: a drive in a machine file; units as in sim_drive.h.
#ifndef SIM_DRIVE_CONFIG_H
#define SIM_DRIVE_CONFIG_H

#include <stdint.h> // uint32_t

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

#endif
