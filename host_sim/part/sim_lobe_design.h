// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_design: the exact profiles of the lobes of a part, for the gauge.
///
/// The frame is fixed to the lobe; angles rise in the sense in which the follower moves round it,
/// from the law's zero. theta is the direction of the roller's line, r the base circle, r1 the
/// roller:
///
///     p = r + r1 + H,  gamma = atan(H' / p),  the normal at the contact points to theta - gamma
///     contact = (p cos gamma - r1) along the normal, p sin gamma across it
///     ds/dtheta = sqrt(p^2 + H'^2) - r1 (1 - gamma')
///
/// Under a flat face theta is the direction of the normal itself:
///
///     contact = r + H along the normal, H' across it,  ds/dtheta = r + H + H''
///
/// Source: MATHS.md (30), (31), (93). The design comes from NAME.json, so the gauge is independent
/// of table and firmware. Error: rounding, below 1e-6 nm.
#ifndef SIM_LOBE_DESIGN_H
#define SIM_LOBE_DESIGN_H

#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // uint32_t

// Lobes with a rise, a dwell at the nose and a fall, by handbook laws.
//
// The rise y(x) goes from 0 at x = 0 to 1 at x = 1; a fall is a reversed rise with its own angle.
// Written from the closed forms of MATHS.md (89) .. (92), independent of the generator, which
// integrates the acceleration of two of them. Error: rounding only.

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

// Lift of the roller's centre by a lobe, over the follower's angle.
//
//     poly345   H = L (10 u^3 - 15 u^4 + 6 u^5),  u = 1 - |theta| / half angle, 0 outside
//     disc      H = sqrt(reach^2 - (e sin theta)^2) + e cos theta - (reach - e)
//     pieces    quintic over each piece of one turn, periodic
//     flanks    a rise, a dwell about the angle 0, a fall
//
// Written from the equations MATHS.md (37), (38), independent of the generator, so that its errors
// show. Error: rounding only.

enum { sim_lobe_lift_terms = 6 };

typedef enum {
    sim_lobe_lift_poly345,
    sim_lobe_lift_disc,
    sim_lobe_lift_pieces,
    sim_lobe_lift_flanks
} sim_lobe_law_t;

typedef struct {
    sim_lobe_law_t law;
    double lift_mm, half_angle_rad; ///< poly345
    double reach_mm, offset_mm;     ///< disc: its radius plus the roller's; distance of its
                                    ///< centre from the axis
    sim_lobe_flanks_t flanks;
    double *break_rad;                ///< pieces: n + 1 rising angles over one turn
    double (*c)[sim_lobe_lift_terms]; ///< [mm/rad^k] n pieces, highest power first
    size_t n;
    size_t i_last; ///< piece of the last look-up, start of the next search
} sim_lobe_lift_t;

/// Read a law from a lobe of a report.
/// @param lift   zero-initialised; the caller frees it, also on failure
/// @param where  dotted path of the lobe, for messages
/// @return       false and *e when something is missing or malformed
bool sim_lobe_lift_read(sim_lobe_lift_t *lift, const cJSON *lobe, const char *where,
                        const char *path, common_error_t *e);

/// @param theta_rad  any angle of the follower
sim_lobe_rise_t sim_lobe_lift_at(sim_lobe_lift_t *lift, double theta_rad);

void sim_lobe_lift_free(sim_lobe_lift_t *lift);

// The lobes

enum { sim_lobe_design_max = 64 };

typedef struct {
    double z_first_mm, z_last_mm;
    double phase_rad; ///< spindle angle at the law's zero
    sim_lobe_lift_t lift;
    double largest_mm; ///< largest lift of the roller's centre, sampled densely
} sim_lobe_t;

typedef struct {
    double base_mm, roller_mm;
    double follower_mm; ///< radius of the wheel when grinding, of the roller when turning
    double base_speed;  ///< nominal speed on the base circle over the mean speed
    bool is_turned;
    bool is_flat;     ///< lifts belong to a flat face, not to a roller
    bool is_even;     ///< made for a constant surface speed
    bool is_plunged;  ///< the wheel plunges into each lobe; only the final surface counts
    uint32_t n_lobes; ///< in order of height
    sim_lobe_t lobe[sim_lobe_design_max];
} sim_lobe_design_t;

/// A point of the profile.
typedef struct {
    double x_mm, y_mm;
    double nx, ny; ///< normal outwards, of length 1
    double ds_mm;  ///< [mm/rad] arc length of the profile per theta
    double bend;   ///< rotation of the normal per theta, 1 on the base circle
} sim_lobe_spot_t;

/// Read "design" of a report.
/// @param d     zero-initialised; the caller frees it, also on failure
/// @param path  for messages
/// @return      false and *e when something is missing or malformed
bool sim_lobe_design_read(sim_lobe_design_t *d, const cJSON *design, const char *path,
                          common_error_t *e);

/// Find the contact of the roller.
/// @param theta_rad  any: direction of the roller's line in the frame of the lobe
sim_lobe_spot_t sim_lobe_design_at(sim_lobe_design_t *d, uint32_t i_lobe, double theta_rad);

/// Find the lobe at a height.
/// @param edge_mm  tolerance at both ends of a lobe
/// @return         its number; n_lobes in the gaps and beyond the ends
uint32_t sim_lobe_design_find(const sim_lobe_design_t *d, double z_mm, double edge_mm);

/// @return [mm] largest lift of all lobes
double sim_lobe_design_lift_mm(const sim_lobe_design_t *d);

void sim_lobe_design_free(sim_lobe_design_t *d);

#endif
