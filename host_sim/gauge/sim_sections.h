// SPDX-License-Identifier: Apache-2.0
/// sim_sections: the true cut radius at evenly spaced points, as a roundness instrument measures
/// it.
///
/// Sections are 3600 angles at one height each; lines are 1025 heights at each of four angles. The
/// tool passes every angle once a turn, between two ticks. There its deviation from the exact
/// surface is interpolated by the cubic through four ticks, its height linearly. Between the tracks
/// of two consecutive passes the deviation is interpolated linearly over the height:
///
///     e(phi, z) = e1 + (z - z1) / (z2 - z1) (e2 - e1),   z1 <= z <= z2 at the angle phi
///     radius    = exact radius of the drawing at (phi, z) + e
///
/// Only the deviation is interpolated, so steep or cornered drawings add no error. A wave of h per
/// turn sampled n times per turn comes out smaller by at most the share 3/128 (2 pi h / n)^4 (0.4 %
/// for h = 50 at n = 480), and by (pi h f)^2 / 2 for h waves per mm of height at the feed f. A pass
/// counts only if all its samples do, so engaging and disengaging turns are left out. For lobes the
/// points are the dexels, evenly spaced over the direction of the roller. Memory does not grow with
/// the cut. Source: MATHS.md (196), (197).
#ifndef SIM_SECTIONS_H
#define SIM_SECTIONS_H

#include <stdbool.h> // bool
#include <stdint.h>  // int64_t

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

/// Record a pass over one point at a height.
/// @param place  any whole number; it wraps
/// @param at     e_mm there; for a lobe also its angle and radius
void sim_sections_pass(sim_sections_t *s, int64_t place, double z_mm, const sim_place_t *at);

/// Break the sequence of samples: another lobe follows, or the tool leaves the work.
void sim_sections_break(sim_sections_t *s);

/// @return [mm] height of a point of a line
double sim_sections_height_mm(const sim_sections_t *s, int i);

#endif
