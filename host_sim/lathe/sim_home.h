// SPDX-License-Identifier: Apache-2.0
/// sim_home: references for homing a slide: a switch at the end of its travel, index marks of its
/// scale or encoder, and the zero of its scale.
#ifndef SIM_HOME_H
#define SIM_HOME_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

typedef struct {
    double switch_mm; ///< position of the switch's edge
    double side;      ///< above 0: active from there upwards; below 0: downwards; 0: no switch
    double pitch_mm;  ///< distance of index marks, one of them at the scale's zero; 0: none
    double zero_mm;   ///< position where the scale counts 0
} sim_home_config_t;

typedef struct {
    sim_home_config_t config;
    bool is_used;        ///< there is a switch or an index
    int32_t zero_nm;     ///< position where the scale counts 0
    double last_mm;      ///< last position
    uint32_t n_left;     ///< [ticks] for which the last index is still shown
    bool is_on, is_seen; ///< on the switch; an index is shown
} sim_home_t;

/// @param place_mm  position of the slide at the start
void sim_home_init(sim_home_t *h, const sim_home_config_t *config, double place_mm);

/// Update with the position of the slide, once per tick.
/// @param n_shown  [ticks] for which an index is shown
void sim_home_look(sim_home_t *h, double place_mm, uint32_t n_shown);

#endif
