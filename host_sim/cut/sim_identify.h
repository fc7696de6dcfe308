// SPDX-License-Identifier: Apache-2.0
/// sim_identify: U of the simulated lathe plays a wave, recorded by the controller.
///
/// It uses the firmware's own commands, as a tool does over CAN: enable, wait for ready, download
/// the wave, excite with keep-alive messages, until the state is ready again. The recording is in
/// the port's memory (cam_recorder.h).
#ifndef SIM_IDENTIFY_H
#define SIM_IDENTIFY_H

#include "cam_machine.h"  // cam_excited_t
#include "common_error.h" // common_error_t
#include "sim_cut.h"      // sim_cut_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t, uint32_t

typedef struct {
    const int32_t *wave; ///< [nm], or [mN] of force; samples of a period, one per tick
    bool is_force;       ///< the samples are forces
    uint32_t n;          ///< [ticks]
    uint32_t n_periods;  ///< at full amplitude
    uint32_t fade_ticks; ///< [ticks] of rise and of fall of the amplitude
    int32_t place_nm;    ///< [nm] centre of the wave on U
    uint32_t signals;    ///< bit i: record signal i
    double alive_s;      ///< [s] duration of keep-alive messages; 0: always
} sim_identify_options_t;

/// Run to the end.
/// @param cut  open, traced, with the firmware in this process
/// @return     false and *e when the controller refuses, or is not ready in time
bool sim_identify_run(sim_cut_t *cut, const sim_identify_options_t *options, common_error_t *e);

/// @return the result
cam_excited_t sim_identify_end(const sim_cut_t *cut);

/// @return rows recorded before the amplitude falls
uint32_t sim_identify_n_played(const sim_cut_t *cut);

#endif
