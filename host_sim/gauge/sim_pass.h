// SPDX-License-Identifier: Apache-2.0
/// sim_pass: how thick the chip is along Z: what the tool has moved since it was here a turn ago.
///
/// A tool that turns metal along a helix cuts what its last pass has left: at the angle phi the
/// thickness z(phi) - z(phi - one turn). It is the feed whenever the path of Z repeats from turn to
/// turn, whatever Z does within the turn. Source: MATHS.md (67).
#ifndef SIM_PASS_H
#define SIM_PASS_H

#include <stdbool.h> // bool

/// Places of a turn at which heights are kept: of this pass and of the last one.
enum { sim_pass_places = 1024, sim_pass_kept = 2 * sim_pass_places };

/// Zero-initialised is before the first sample.
typedef struct {
    double z_mm[sim_pass_kept]; ///< over the places, two turns of them
    double turn, last_z_mm;     ///< the last sample
    bool is_begun;
} sim_pass_t;

/// The tool has come to a place. Before the first sample it is taken as having turned at its
/// height.
/// @param turn  [turn] spindle angle in the sense of cutting, not wrapped, rising; a sample that
///              goes back leaves the pass as it is
/// @return      [mm] thickness of the chip, >= 0, linear between the places
double sim_pass_touch(sim_pass_t *p, double turn, double z_mm);

#endif
