// SPDX-License-Identifier: Apache-2.0
/// sim_home: what a slide is homed by: a switch at the end of its way, index marks of its scale or
/// encoder, and the place where its scale counts 0.
#ifndef SIM_HOME_H
#define SIM_HOME_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

typedef struct {
    double switch_mm; ///< place of the switch's edge
    double side;      ///< above 0: active from there upwards, below 0: downwards, 0: no switch
    double pitch_mm;  ///< from index to index, the first one where the scale counts 0; 0: none
    double zero_mm;   ///< place where the scale counts 0
} sim_home_config_t;

typedef struct {
    sim_home_config_t config;
    double last_mm;      ///< place at the last look
    uint32_t n_left;     ///< [ticks] for which the index that was passed last is still shown
    bool is_on, is_seen; ///< on the switch, an index is shown
} sim_home_t;

/// @param place_mm  of the slide at the start
void sim_home_init(sim_home_t *h, const sim_home_config_t *config, double place_mm);

/// Look where the slide is, once per tick.
/// @param n_shown  [ticks] for which an index is shown
void sim_home_look(sim_home_t *h, double place_mm, uint32_t n_shown);

/// @return [nm] where the scale counts 0
int32_t sim_home_zero_nm(const sim_home_t *h);

#endif
