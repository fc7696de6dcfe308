// SPDX-License-Identifier: Apache-2.0
/// sim_pass: thickness of the chip along Z: the tool's travel since it was here a turn ago.
///
/// On a helix the tool cuts what the last pass left: at the angle phi the thickness is z(phi) -
/// z(phi - one turn). It equals the feed whenever the path of Z repeats from turn to turn, whatever
/// Z does within the turn. Source: MATHS.md (67).
#ifndef SIM_PASS_H
#define SIM_PASS_H

#include <stdbool.h> // bool

/// Angles per turn at which heights are kept, for this pass and the last.
enum { sim_pass_places = 1024, sim_pass_kept = 2 * sim_pass_places };

/// Zero-initialised: before the first sample.
typedef struct {
    double z_mm[sim_pass_kept]; ///< heights over two turns
    double turn, last_z_mm;     ///< the last sample
    bool is_begun;
} sim_pass_t;

/// Take a sample of the tool. Before the first one the tool counts as having turned at its height.
/// @param turn  [turn] spindle angle in the sense of cutting, not wrapped, rising; a sample that
///              goes back changes nothing
/// @return      [mm] thickness of the chip, >= 0, interpolated linearly
double sim_pass_touch(sim_pass_t *p, double turn, double z_mm);

#endif
