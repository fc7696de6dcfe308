// SPDX-License-Identifier: Apache-2.0
/// sim_work: the blank, the tool tip on it, and a roundness gauge. Memory does not grow with the
/// cut; without a map most of it is never touched.
///
///     error = radius of the tool tip - exact radius at the tool's true angle and height
///     cut depth = blank radius - radius,  removed volume: dV = pi (blank^2 - radius^2) dz
///
/// The exact radius is that of the tip's path, for a round nose where it just touches the surface
/// (below), so the error is that of the surface at the contact. One turn removes a ring as
/// wide as the feed, of which each sample covers dz; sim_scallop.h models the feed marks between
/// turns. The map keeps, per cell of angle and height, the sample with the largest |error|; each
/// row of heights keeps the extremes, whose difference is its roundness. The error against the
/// drawing is the form error; against a refit or filter that the table plays instead it is the
/// control error.
#ifndef SIM_WORK_H
#define SIM_WORK_H

#include "sim_design.h" // sim_design_t
#include <stdbool.h>    // bool
#include <stddef.h>     // size_t
#include <stdint.h>     // uint32_t, uint64_t

enum { sim_work_columns = 720, sim_work_rows = 256 };

/// The worst sample of a cell.
typedef struct {
    float turn; ///< [turn] drawing's angle, 0 .. 1
    float error_nm;
    double z_mm;
    double radius_mm;
    uint32_t n;     ///< samples seen; 0: none
    float slope_um; ///< [um/rad] of the drawing; not a number where it is not known
} sim_cell_t;

/// One band of heights.
typedef struct {
    double min_um, max_um, sum_um2;
    uint64_t n;
} sim_row_t;

typedef struct {
    double blank_mm; ///< radius of the blank
    double z_first_mm, z_last_mm, rows_per_mm;
    double max_um, sum_um2;    ///< form error: largest magnitude, sum of squares
    double max_turn, max_z_mm; ///< place of the largest
    double depth_min_mm, depth_max_mm;
    double removed_mm3;
    double gouge_um;                 ///< deepest cut below the exact surface in any state, above 0
    double last_z_mm;                ///< of the last counted sample
    double last_turn, last_exact_mm; ///< of the last judged sample
    double last_slope_um;            ///< [um/rad] of the drawing, before the last judged sample
    double turned_um2, slope_um2;    ///< sums of error times slope and of slope squared; the slope
                                     ///< in um per radian
    uint64_t n;                      ///< counted samples
    bool has_map;                    ///< `cell` is kept
    sim_row_t row[sim_work_rows];
    sim_cell_t cell[sim_work_rows][sim_work_columns]; ///< the last member
} sim_work_t;

/// @param w         7 MB: allocate it
/// @param blank_mm  radius of the blank
/// @param has_map   keep the worst sample of each cell
void sim_work_init(sim_work_t *w, double blank_mm, double z_first_mm, double z_last_mm,
                   bool has_map);

/// Take a sample of the tool tip.
/// @param turn        [turn] 0 .. 1 from the long axis
/// @param exact_mm    exact radius there
/// @param is_counted  the sample belongs to the judged surface: full amplitude and depth
void sim_work_touch(sim_work_t *w, double turn, double z_mm, double radius_mm, double exact_mm,
                    bool is_counted);

/// Judge a sample without counting removed metal, which sim_lobe_work counts by dexels.
void sim_work_judge(sim_work_t *w, double turn, double z_mm, double radius_mm, double exact_mm,
                    bool is_counted);

/// @return [rad] angle by which the whole part is turned: the least-squares part of the error that
///         follows the slope of the drawing; 0 for a round part
double sim_work_turned_rad(const sim_work_t *w);

/// @return [um] rms form error without that part
double sim_work_shape_rms_um(const sim_work_t *w);

/// @return [um] largest magnitude of the form error without that part, of the worst samples of the
///         cells of the map
double sim_work_shape_max_um(const sim_work_t *w);

/// @return [um] rms form error, 0 without samples
double sim_work_rms_um(const sim_work_t *w);

/// @return [um] largest roundness of all rows, 0 without samples
double sim_work_roundness_um(const sim_work_t *w);

// Tip position of a round nose that just touches the exact surface.
//
//     tip(phi, z_tip) = max over z of  R(phi, z) + sqrt(r^2 - (z - z_tip)^2) - r
//
// The tip's radius less this one is the error of the part at the contact, whatever was commanded.
// The maximum is searched over the circle's heights: on equal steps, then by golden section
// between the neighbours of the best. The search uses no slope of the surface and none of the
// generator's method. It covers 3 r s to both sides of the tip, s being the steepest slope of 256
// heights at 24 angles; a contact is within r s. There is no surface beyond the ends of the part:
// a nose that is beside the part and nearest to its end cuts nothing there. Error below 1e-3 nm on
// a smooth surface, below 1e-5 sqrt(r) of a kink's angle next to a kink. Source: MATHS.md (107),
// (110).

typedef struct {
    double nose_mm;  ///< radius; 0: the tool has a point
    double reach_mm; ///< largest distance from the tip to a contact
} sim_nose_t;

/// @param nose_mm  radius of the nose, 0 for a point
/// @param design   of a skirt; a table used as the design holds the path of the tip, so the nose
///                 counts as a point
void sim_nose_init(sim_nose_t *n, double nose_mm, sim_design_t *design);

/// @param turn  [turn] angle from the long axis, 0 .. 1
/// @param z_mm  height of the tip, any
/// @param is_beside  set when the nose would touch an end of the part from beside it
/// @return      [mm] radius at which the tip just touches; with a point the radius of the surface
double sim_nose_radius_mm(const sim_nose_t *n, sim_design_t *design, double turn, double z_mm,
                          bool *is_beside);

#endif
