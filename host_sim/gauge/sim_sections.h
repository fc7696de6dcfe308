// SPDX-License-Identifier: Apache-2.0
/// sim_sections: the true cut radius at evenly spaced places, as a roundness instrument takes it.
///
/// Sections are 3600 angles at one height each; lines are 1025 heights at each of four angles. The
/// tool passes every angle once a turn, between two ticks. Its deviation from the exact surface is
/// interpolated there by the cubic through four ticks, its height linearly. Two passes that
/// follow one another enclose heights; there the deviation is interpolated linearly between the
/// two tracks:
///
///     e(phi, z) = e1 + (z - z1) / (z2 - z1) (e2 - e1),   z1 <= z <= z2 at the angle phi
///     radius    = exact radius of the drawing at (phi, z) + e
///
/// What is interpolated is the deviation alone, so a steep or cornered drawing costs nothing. A
/// wave of h per turn sampled n times per turn comes out smaller by the share 3/128 (2 pi h / n)^4
/// at most (0.4 % of h = 50 at n = 480), and by (pi h f)^2 / 2 for h waves per mm of height at the
/// feed f. Passes count only while all their samples do, so engaging and disengaging turns make no
/// section. Of lobes the places are the dexels, evenly spaced over the direction of the roller.
/// The memory is bounded, however long the cut. Source: MATHS.md (196), (197).
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

/// One place of a section.
typedef struct {
    double e_mm;     ///< deviation, above 0: metal left; NAN: no pass
    double turn;     ///< [turn] of a lobe: polar angle, 0 .. 1
    double drawn_mm; ///< of a lobe: radius of the exact profile
} sim_place_t;

/// A sample of the tool.
typedef struct {
    double turn; ///< [turn] drawing's angle, not wrapped: rises with M3, falls with M4
    double z_mm, e_mm;
} sim_section_tip_t;

/// Zero-initialised nothing is made.
typedef struct {
    int n; ///< sections; 0: all calls do nothing
    double z_mm[sim_sections_most];
    double first_mm, step_mm; ///< heights of the lines
    int n_tips;               ///< 0 .. 4 samples that followed one another
    sim_section_tip_t tip[4]; ///< the oldest first
    bool has_passes;          ///< there is a pass in before_*
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

/// A pass over one place at a height.
/// @param place  any whole number; it wraps
/// @param at     e_mm there; of a lobe its angle and radius, too
void sim_sections_pass(sim_sections_t *s, int64_t place, double z_mm, const sim_place_t *at);

/// What comes is no neighbour of what was: another lobe, or the tool leaves the work.
void sim_sections_break(sim_sections_t *s);

/// @return [mm] height of a place of a line
double sim_sections_height_mm(const sim_sections_t *s, int i);

#endif
