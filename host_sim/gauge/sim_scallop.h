// SPDX-License-Identifier: Apache-2.0
/// sim_scallop: the surface between the tracks of a tool with a round nose.
///
///     left(phi, z) = min over all passes of  tip + r - sqrt(r^2 - (z - z_tip)^2)
///
/// in a window of heights, at 240 angles of the turn: whenever the tool passes one of them, the
/// circle of its nose cuts the surface there, starting from the blank. Between two ticks the tip's
/// height and its distance from the exact surface are linear, with errors below 0.01 nm and 1 nm on
/// a skirt. The nose is in the plane of the axis; its lowest point is the tip. The map holds the
/// height above the exact surface; a slope s of the surface lowers it by r s^2 / 2 everywhere (0.02
/// um for 0.8 mm and 0.0063) and does not change peak to valley. Source: MATHS.md (65).
#ifndef SIM_SCALLOP_H
#define SIM_SCALLOP_H

#include "sim_design.h" // sim_design_t
#include <stdbool.h>    // bool

enum { sim_scallop_angles = 240, sim_scallop_heights = 401 };

/// The tip at an instant.
typedef struct {
    double turn, z_mm;
    double proud_mm; ///< above the exact surface
} sim_scallop_tip_t;

typedef struct {
    double nose_mm;                                          ///< radius; 0: no map
    double z_first_mm, z_last_mm;                            ///< the window, ends included
    bool has_last;                                           ///< `last` is valid
    sim_scallop_tip_t last;                                  ///< previous sample
    double left_mm[sim_scallop_angles][sim_scallop_heights]; ///< radius of the surface
} sim_scallop_t;

/// Results of the map.
typedef struct {
    double highest_um, lowest_um; ///< largest and least peak to valley of an angle
    double mean_um;               ///< mean height above the exact surface
} sim_scallop_figures_t;

/// @param s         1 MB: allocate it
/// @param nose_mm   radius of the nose; 0: the other calls do nothing
/// @param blank_mm  radius of the blank
void sim_scallop_init(sim_scallop_t *s, double nose_mm, double z_first_mm, double z_last_mm,
                      double blank_mm);

/// Take a sample of the tool tip. Two consecutive samples less than half a turn apart, in either
/// sense, cut.
/// @param turn       [turn] drawing's angle, 0 .. 1
/// @param radius_mm  of the tip
void sim_scallop_touch(sim_scallop_t *s, sim_design_t *design, double turn, double z_mm,
                       double radius_mm);

/// @return [mm] height of a row of the map
double sim_scallop_height_mm(const sim_scallop_t *s, int height);

/// @return [um] height above the exact surface at a point of the map
double sim_scallop_proud_um(const sim_scallop_t *s, sim_design_t *design, int angle, int height);

sim_scallop_figures_t sim_scallop_figures(const sim_scallop_t *s, sim_design_t *design);

#endif
