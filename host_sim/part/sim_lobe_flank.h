// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_flank: lobes with a rise, a dwell at the nose and a fall, by handbook laws.
///
/// The rise y(x) goes from 0 at x = 0 to 1 at x = 1; a fall is a reversed rise with its own angle.
/// Written from the closed forms of MATHS.md (89) .. (92), independent of the generator, which
/// integrates the acceleration of two of them. Error: rounding only.
#ifndef SIM_LOBE_FLANK_H
#define SIM_LOBE_FLANK_H

#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool

typedef enum {
    sim_lobe_flank_poly345,
    sim_lobe_flank_cycloidal,
    sim_lobe_flank_modified_sine,
    sim_lobe_flank_modified_trapezoid,
    sim_lobe_flank_harmonic,
    sim_lobe_flank_polydyne,
    sim_lobe_n_flanks
} sim_lobe_flank_t;

typedef struct {
    sim_lobe_flank_t shape;
    double lift_mm;
    double rise_rad, dwell_rad, fall_rad;    ///< the middle of the dwell is at the angle 0
    double rise_deflection, fall_deflection; ///< polydyne: deflection of the follower
} sim_lobe_flanks_t;

/// Lift and its derivatives over the angle.
typedef struct {
    double h_mm;
    double h1_mm; ///< [mm/rad]
    double h2_mm; ///< [mm/rad2]
} sim_lobe_rise_t;

/// Read flanks from a lobe of a report.
/// @param where  dotted path of the lobe, for messages
/// @return       false and *e when something is missing or malformed
bool sim_lobe_flanks_read(sim_lobe_flanks_t *f, const cJSON *lobe, const char *where,
                          const char *path, common_error_t *e);

/// @param theta_rad  any angle of the follower
sim_lobe_rise_t sim_lobe_flanks_at(const sim_lobe_flanks_t *f, double theta_rad);

#endif
