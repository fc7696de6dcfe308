// SPDX-License-Identifier: Apache-2.0
/// sim_design: the exact surface of the part in double, the reference of the gauge.
///
///     radius(phi, z) = a(z) - delta(phi, z),  phi from the long axis, G(z) = 2a - 2b
///     ellipse          delta = a k sin^2 phi / (q (q + 1)),
///                      k = (a^2 - b^2) / b^2, q = sqrt(1 + k sin^2 phi)
///     cosine           delta = (G / 2) sin^2 phi
///     double-ellipse   delta = (G / 4) ((1 - cos 2 phi) + (beta / 25) (1 - cos 4 phi))
///     ellipse-arc      one of these ovals and an eccentric circle, corner included
///     surface          delta from polynomial pieces (sim_surface.h)
///     sides            delta of ovals that differ from side to side (sim_surface.h)
///     all of them      less a correction (sim_surface.h)
///     lobes            another frame and gauge: sim_lobe_design.h
///
/// a(z) and G(z) are piecewise cubics, clamped outside. They come from NAME.json, the generator's
/// report next to NAME.camtab, so the gauge is independent of table and firmware. Without the
/// report the table, evaluated in double, is the reference; errors of the table then do not show.
/// Source: MATHS.md (1) .. (4); rounding below 1e-5 nm.
#ifndef SIM_DESIGN_H
#define SIM_DESIGN_H

#include "cam_table.h"       // cam_table_t
#include "common_error.h"    // common_error_t
#include "sim_area.h"        // sim_areas_t
#include "sim_band.h"        // sim_bands_t
#include "sim_json.h"        // sim_cubics_t
#include "sim_lobe_design.h" // sim_lobe_design_t
#include "sim_surface.h"
#include <stdbool.h> // bool

// A section of an oval and an eccentric circle, with their corner, MATHS.md (10), (11).
//
//     phi < joint    the oval, reduction delta(phi)
//     phi >= joint   rho = sqrt(R^2 - e^2 cos^2 phi) - e sin phi,  R = B + e
//     P = a - delta(joint),  B = a - G/2 - trim,  e = (P - B) (P + B) / (2 (B - P sin joint))
//
// phi is folded into the first quadrant. Error: rounding only, below 1e-6 nm.

typedef struct {
    double eccentricity_mm, radius_mm;
} sim_arc_t;

/// Derive the circle that meets the oval at the joint and is `trim` below it on the short axis.
/// @param at_joint_mm  reduction of the oval at the joint
/// @param sin_joint    sine of the joint's angle
sim_arc_t sim_arc_of(double a_mm, double g_mm, double trim_mm, double at_joint_mm,
                     double sin_joint);

/// @return [mm] distance of the circle from the centre of the part; sin_phi 0 .. 1
double sim_arc_radius_mm(const sim_arc_t *arc, double sin_phi);

// The design

typedef enum {
    sim_shape_ellipse,
    sim_shape_cosine,
    sim_shape_double_ellipse,
    sim_shape_surface, ///< refitted and measured sections
    sim_shape_arc,     ///< oval and eccentric circle
    sim_shape_sides,   ///< ovals that differ over height or from side to side
    sim_shape_lobes,   ///< sim_lobe_design.h; no radius over angle and height
    sim_shape_table,   ///< no report: the table's own quintics
} sim_shape_t;

typedef struct {
    sim_shape_t shape;
    double beta;
    sim_cubics_t radius_mm, ovality_mm;
    sim_shape_t oval;        ///< sim_shape_arc only: ellipse, cosine or double-ellipse
    sim_cubics_t trim_mm;    ///< ... radial, below the oval at the short axis
    sim_cubics_t joint_turn; ///< ... where the circle begins
    sim_surface_t surface;   ///< sim_shape_surface only
    sim_sides_t sides;       ///< sim_shape_sides only
    bool is_turned;          ///< the sections are rotated by phase_rad over height
    sim_cubics_t phase_rad;
    sim_correction_t correction;  ///< empty: none
    sim_areas_t areas;            ///< windows and zones of a skirt's drawing
    sim_bands_t bands;            ///< turned one after the other; n = 0: the part is one
    sim_lobe_design_t lobes;      ///< sim_shape_lobes only
    const cam_table_t *table;     ///< sim_shape_table only
    double nose_mm;               ///< nose of the tool for which the table is made; 0: a point
    double z_first_mm, z_last_mm; ///< ends of the part; the table may extend beyond them
    bool is_run_into;             ///< the tool enters along Z, from below the part
    bool is_run_out_of;           ///< ... and leaves above it
    double largest_mm;            ///< largest long half axis; of lobes base circle and lift
    double at_z_mm;               ///< height of the cached values
    double a_mm, g_mm;            ///< a(z) and G(z) there
    sim_arc_t arc;                ///< sim_shape_arc only: the circle there
    double sin_joint;             ///< ... and the sine of the joint
} sim_design_t;

/// Read the report of a table.
/// @param path   of NAME.json
/// @param table  its CRC-32 must equal the report's
/// @return       false and *e when it cannot be read, is malformed or belongs to another table
bool sim_design_load(sim_design_t *d, const char *path, const cam_table_t *table,
                     common_error_t *e);

/// Read the surface that the table plays instead of the drawing: a refit or a filter.
/// @param is_there  false when the table plays the drawing itself; *d is empty then
/// @return          false and *e as sim_design_load
bool sim_design_load_target(sim_design_t *d, bool *is_there, const char *path,
                            const cam_table_t *table, common_error_t *e);

/// Use the table itself as the design, its knots evaluated in double.
/// @param table  checked; must outlive the design
void sim_design_from_table(sim_design_t *d, const cam_table_t *table);

/// Find the ends of the band at a height: those of the part where it has none there.
void sim_design_ends(const sim_design_t *d, double z_mm, double *first_mm, double *last_mm);

void sim_design_free(sim_design_t *d);

/// Evaluate the exact radius of the part.
/// @param turn  [turn] drawing's angle, 0 .. 1
/// @param z_mm  any; clamped to the part
double sim_design_radius_mm(sim_design_t *d, double turn, double z_mm);

/// @return [mm] long half axis at a height
double sim_design_long_mm(sim_design_t *d, double z_mm);

/// Sample a(z) densely over the range of the design. @return [mm] its largest value
double sim_design_find_largest_mm(sim_design_t *d);

/// @return whether a tool at a height is on the part; where the table ends with the part, also
///         beyond that end
bool sim_design_is_on_part(const sim_design_t *d, double z_mm);

/// @param shape  ellipse, cosine or double-ellipse
/// @return [mm] reduction of the radius; s2 = sin^2 phi
double sim_design_delta_mm(sim_shape_t shape, double beta, double a_mm, double g_mm, double s2);

// The surface of a table in double: the firmware's quintics without fixed-point rounding.

/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any; clamped to the channels
/// @return      [mm] x - u. Source: TABLE_FORMAT.md, "Knots".
double sim_design_table_radius_mm(const cam_table_t *t, double turn, double z_mm);

/// @param turn  [turn] drawing's angle, any
/// @return      spindle speed over its mean; 1 without a speed channel
double sim_design_table_ratio(const cam_table_t *t, double turn, double z_mm);

/// @return [mm] the long half axis x
double sim_design_table_long_mm(const cam_table_t *t, double z_mm);

#endif
