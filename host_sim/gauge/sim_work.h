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
#include <stdint.h>     // uint32_t, uint64_t, int64_t

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

/// Count the metal that a sample removes. @param radius_mm  blank_mm where there is none
void sim_work_remove(sim_work_t *w, double z_mm, double radius_mm, bool is_counted);

/// Judge a sample of the tool tip.
/// @param turn        [turn] 0 .. 1 from the long axis
/// @param exact_mm    exact radius there
/// @param is_counted  the sample belongs to the judged surface: full amplitude and depth
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

// The true cut radius at evenly spaced points, as a roundness instrument measures it.
//
// Sections are 3600 angles at one height each; lines are 1025 heights at each of four angles. The
// tool passes every angle once a turn, between two ticks. There its deviation from the exact
// surface is interpolated by the cubic through four ticks, its height linearly. Between the tracks
// of two consecutive passes the deviation is interpolated linearly over the height:
//
//     e(phi, z) = e1 + (z - z1) / (z2 - z1) (e2 - e1),   z1 <= z <= z2 at the angle phi
//     radius    = exact radius of the drawing at (phi, z) + e
//
// Only the deviation is interpolated, so steep or cornered drawings add no error. A wave of h per
// turn sampled n times per turn comes out smaller by at most the share 3/128 (2 pi h / n)^4 (0.4 %
// for h = 50 at n = 480), and by (pi h f)^2 / 2 for h waves per mm of height at the feed f. A pass
// counts only if all its samples do, so engaging and disengaging turns are left out. For lobes the
// points are the dexels, evenly spaced over the direction of the roller. Memory does not grow with
// the cut. Source: MATHS.md (196), (197).

enum {
    sim_sections_places = 3600, ///< 7.2 for each of 500 waves per turn
    sim_sections_most = 16,
    sim_sections_lines = 4, ///< at 0, 90, 180 and 270 degrees
    sim_sections_heights = 1025
};

/// One point of a section.
typedef struct {
    double e_mm;     ///< deviation, above 0: metal left; NAN: no pass
    double turn;     ///< [turn] lobes: polar angle, 0 .. 1
    double drawn_mm; ///< lobes: radius of the exact profile
} sim_place_t;

/// A sample of the tool.
typedef struct {
    double turn; ///< [turn] drawing's angle, not wrapped: rises with M3, falls with M4
    double z_mm, e_mm;
} sim_section_tip_t;

/// Zero-initialised: no sections.
typedef struct {
    int n; ///< sections; 0: all calls do nothing
    double z_mm[sim_sections_most];
    double first_mm, step_mm; ///< heights of the lines
    int n_tips;               ///< 0 .. 4 consecutive samples
    sim_section_tip_t tip[4]; ///< the oldest first
    double skipped_turn;      ///< [turn] of the last sample in a window
    bool has_passes;          ///< before_* hold a pass
    double before_z_mm[sim_sections_places], before_e_mm[sim_sections_places]; ///< NAN: none
    sim_place_t section[sim_sections_most][sim_sections_places];
    double line_e_mm[sim_sections_lines][sim_sections_heights]; ///< NAN: no pass
} sim_sections_t;

/// @param s     2 MB: allocate it
/// @param z_mm  n heights of sections, n <= sim_sections_most
/// @param z_first_mm, z_last_mm  ends of the part
void sim_sections_init(sim_sections_t *s, const double *z_mm, int n, double z_first_mm,
                       double z_last_mm);

/// Take a sample of the tip of a skirt's tool.
/// @param turn        [turn] drawing's angle, not wrapped
/// @param e_mm        radius of the tip less exact radius
/// @param is_counted  the sample belongs to the surface that is judged
void sim_sections_touch(sim_sections_t *s, double turn, double z_mm, double e_mm, bool is_counted);

/// Take a sample in a window: it is not gauged, and nothing is interpolated across it.
/// @param turn  [turn] drawing's angle, not wrapped
void sim_sections_skip(sim_sections_t *s, double turn);

/// Record a pass over one point at a height.
/// @param place  any whole number; it wraps
/// @param at     e_mm there; for a lobe also its angle and radius
void sim_sections_pass(sim_sections_t *s, int64_t place, double z_mm, const sim_place_t *at);

/// Break the sequence of samples: another lobe follows, or the tool leaves the work.
void sim_sections_break(sim_sections_t *s);

/// @return [mm] height of a point of a line
double sim_sections_height_mm(const sim_sections_t *s, int i);

// The error of every turn in rehearsal and cut, which shows how learning converges.
//
// In the cut it is the largest |form error| of the turn; the last turn may be incomplete. In a
// rehearsal the tool is clear of the work, and the true position of U is compared with the drawing
// at the true angle: the error is half the difference between the largest and the smallest
// deviation in the turn, which a constant offset does not change. Turns with rising or falling
// amplitude are left out: they are found by number, counted from the first turn in which U moves
// and back from the end of the rehearsal.
//
// Memory is bounded: when it is full, neighbours of the same kind merge into one entry with the
// larger error.

enum { sim_turns_most = 4096 };

typedef enum { sim_turns_rehearsed, sim_turns_cut } sim_turns_kind_t;

/// One turn, or several merged.
typedef struct {
    double turn; ///< [turn] where it began, counted from the first sample
    double um;
    sim_turns_kind_t kind;
} sim_turn_t;

/// Zero-initialised: no turn.
typedef struct {
    double rise_turns, fall_turns; ///< of the amplitude in a rehearsal
    double kept_turns;             ///< [turn] turns of a rehearsal at full amplitude
    // the present run of turns
    bool has_begun;
    double zero_turn;  ///< angle of the very first sample
    double begin_turn; ///< ... of the present run
    double full_turn;  ///< where the amplitude begins to rise, from zero_turn; below 0: not yet
    uint32_t run_from; ///< first entry of the run
    bool is_running;
    sim_turns_kind_t kind;
    // the present turn
    double n_whole; ///< whole turns of the run before this one
    double least_um, most_um;
    double least_u_um, most_u_um, least_drawn_um, most_drawn_um;
    uint32_t n;
    sim_turn_t entry[sim_turns_most];
} sim_turns_t;

/// @param rise_turns, kept_turns, fall_turns  of a rehearsal: amplitude rises, stays, falls
void sim_turns_init(sim_turns_t *t, double rise_turns, double kept_turns, double fall_turns);

/// Take a sample of a rehearsal.
/// @param turn      [turn] true angle, not wrapped; it may fall
/// @param u_um      true position of U's tip, positive towards the axis
/// @param drawn_um  radius of the drawing there
void sim_turns_rehearse(sim_turns_t *t, double turn, double u_um, double drawn_um);

/// Take a sample of the cut. @param error_um  above 0: metal left
void sim_turns_touch(sim_turns_t *t, double turn, double error_um);

/// Take a sample of any other state, which ends a run.
/// @param is_engaging  the rehearsal was completed; otherwise it was aborted
void sim_turns_rest(sim_turns_t *t, double turn, bool is_engaging);

#endif
