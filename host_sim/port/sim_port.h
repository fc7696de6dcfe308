// SPDX-License-Identifier: Apache-2.0
/// sim_port: connects the lathe to hal/host: the firmware's inputs and outputs.
///
/// Time advances in ticks. At the start of a tick the true state is written to hal_host.in; the
/// firmware runs; the lathe reads its outputs and advances by one period.
///
///     sense: lathe -> hal_host.in     tick (sim_firmware.h)     advance: hal_host.out -> lathe
///
/// Between sense and advance the true state is that at the instant of sensing.
#ifndef SIM_PORT_H
#define SIM_PORT_H

#include "sim_clock.h"  // sim_clock_t
#include "sim_home.h"   // sim_home_t
#include "sim_inject.h" // sim_inject_t
#include "sim_lathe.h"  // sim_lathe_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t, uint64_t

typedef struct {
    sim_lathe_t lathe;
    double time_s;
    uint32_t n_swing;      ///< set-points of the swing applied
    int32_t swing_set_q32; ///< [turn / 2^32] set-point in force
    int32_t z_offset_nm;   ///< added to the measured Z
    sim_home_t home[hal_n_axes];
    uint32_t n_shown;  ///< [ticks] for which the port shows an index: the period of the plan
    sim_clock_t clock; ///< when ticks occur
    double late_s;     ///< delay of the next tick
    double lost_s;     ///< time beyond the nominal time of all ticks
} sim_port_t;

/// Reset hal/host, with the lathe at rest; U is measured.
/// @param x_nm, z_nm  positions at the start
/// @param seed        seed of all noise
void sim_port_init(sim_port_t *p, const sim_lathe_config_t *config, double x_nm, double z_nm,
                   uint64_t seed);

/// Before a tick: set the inputs of the firmware.
void sim_port_sense(sim_port_t *p);

/// After a tick: advance by one period.
void sim_port_advance(sim_port_t *p);

/// Apply an injection to lathe or port; other kinds (table-flip, stop, those of the nodes) do
/// nothing. Call it between sense and advance.
/// @param direction  +1 or -1: sense of cutting
void sim_port_inject(sim_port_t *p, const sim_inject_t *inject, int direction);

/// @return [degrees] set-point of the swing in the last tick
static inline double sim_port_swing_set_deg(const sim_port_t *p)
{
    return p->swing_set_q32 * (360.0 / 4294967296.0);
}

#endif
