// SPDX-License-Identifier: Apache-2.0
/// sim_removal: metal removed per time slice, measured on the workpiece, and the cutting forces.
///
///     dV = (blank^2 - radius^2) / 2 h dphi     of every tick, along the true tool path
///     rate = V / dt,  power = kc rate          constant in equal-volume turning
///     rate force = kc V / feed                 the papers' model: area cut in one slice
///     chip force = kc mean (depth h)           physical: section of the chip, whatever the speed
///
/// h is the travel of Z since the last pass over this angle. kc is constant, or with
/// an exponent of the size effect (Kienzle) kc1.1 h^-mc.
///
/// A slice ends with the first tick at or after its due time: on average slices last dt, and each
/// counts with its true length. Ripple is (largest - least) / mean over the slices of one turn.
/// Only whole turns count in which every sample has `is_judged`. Source: MATHS.md (29), (67), (86).
#ifndef SIM_REMOVAL_H
#define SIM_REMOVAL_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint64_t

// Thickness of the chip along Z: the tool's travel since it was here a turn ago.
//
// On a helix the tool cuts what the last pass left: at the angle phi the thickness is z(phi) -
// z(phi - one turn). It equals the feed whenever the path of Z repeats from turn to turn, whatever
// Z does within the turn. Source: MATHS.md (67).

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

// The removal

typedef struct {
    double blank_mm;      ///< radius of the blank
    double feed_mm;       ///< per turn
    double slice_s;       ///< [s] > 0
    double kc_n_mm2;      ///< specific cutting force, with a size effect that of a chip of 1 mm
    double size_exponent; ///< mc of Kienzle, 0 .. 1; 0: no size effect
    double nose_mm;       ///< radius of the tool's nose for the size effect; 0: a square edge
} sim_removal_config_t;

/// One finished slice.
typedef struct {
    double t_s;  ///< its middle
    double turn; ///< [turn] spindle angle there, whole turns counted
    double z_mm; ///< height at its end
    double volume_mm3, rate_mm3_s, power_w, rate_force_n, chip_force_n;
} sim_slice_t;

/// The smallest, the largest and the sum of some values.
typedef struct {
    double min, max, sum;
    uint64_t n;
} sim_spread_t;

typedef struct {
    sim_removal_config_t config;
    sim_slice_t slice; ///< the last finished one
    // the present slice
    double begin_s, due_s, begin_turn, volume_mm3, work_nmm, force_sum_n, last_turn;
    double last_cut_mm3; ///< [mm3/turn] of the last sample
    sim_pass_t pass;
    uint64_t n; ///< samples in the slice
    bool is_running, is_clean;
    // the present turn
    double turn; ///< whole turns of its slices
    bool is_whole;
    sim_spread_t turn_rate, turn_force;
    // all judged turns
    double removed_mm3; ///< all samples
    sim_spread_t rate, power, rate_force, chip_force, rate_ripple, force_ripple;
} sim_removal_t;

void sim_removal_init(sim_removal_t *r, const sim_removal_config_t *config);

/// Take a sample of the cutting tool.
/// @param t_s        [s] rising
/// @param turn       [turn] spindle angle in the sense of cutting, not wrapped
/// @param is_judged  the feed is at its full value
/// @return           true when a slice was finished: r->slice
bool sim_removal_touch(sim_removal_t *r, double t_s, double turn, double z_mm, double radius_mm,
                       bool is_judged);

/// Count one more value.
void sim_spread_add(sim_spread_t *s, double value);

/// @return mean, 0 without samples
double sim_spread_mean(const sim_spread_t *s);

#endif
