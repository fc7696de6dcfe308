// SPDX-License-Identifier: Apache-2.0
/// cam_table_inner: the parts of cam_table_check(), private to this room.
///
/// The check reads the entries of the image's directory one by one: the entry and its knots or
/// records (cam_entry), the range of the values between the knots (cam_bounds, cam_extent), the
/// feed and the lobes, last the peaks of the motion (cam_peaks). Read them in this order.
/// Context of all functions: slow side. Source: TABLE_FORMAT.md.
#ifndef CAM_TABLE_INNER_H
#define CAM_TABLE_INNER_H

#include "cam_err.h"   // cam_err_t
#include "cam_table.h" // cam_table_t
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t
#include <stdint.h>    // uint32_t, int32_t

/// Kind of a channel, as stored in its entry.
enum {
    cam_kind_u = 1,       ///< radius reduction over angle and height
    cam_kind_x = 2,       ///< semi-major axis over height
    cam_kind_speed = 3,   ///< speed ratio of the spindle over angle and height
    cam_kind_swing = 4,   ///< lobe: swing angle of the tool over angle and height
    cam_kind_contact = 5, ///< lobe: angle of the contact on the wheel, reported, not played
    cam_kind_lobes = 6,   ///< position of each lobe on the shaft and the slice it plays
    cam_kind_way = 7,     ///< Z in advance of a plain helix, over the helix's height
    cam_kind_passes = 8,  ///< records of the passes in which the part is cut
    cam_kind_newer = 6,   ///< kinds from here on need version 1.1
};

enum {
    cam_entry_align = 32,                 ///< [bytes] alignment of a channel in the image
    cam_entry_max_height_nm = 2000000000, ///< [nm] heights and their differences fit int32
};

/// A channel entry, in the order of the image.
typedef struct {
    uint32_t kind;       ///< cam_kind_*
    uint32_t offset;     ///< [bytes] of the first knot from the start of the image
    uint32_t size;       ///< [bytes] of all knots
    uint32_t n_slices;   ///< 2 .. 4096
    uint32_t log2_knots; ///< over angle: 2 .. 12; x and way: 0
    uint32_t log2_repeat, frac_bits;
    int32_t z_first_nm, z_last_nm;
    uint32_t slices_per_nm_q48;
    int32_t value_offset;        ///< [unit of the channel] value at p = 0
    int32_t p_min, p_max;        ///< [LSB] bounds of p of all knots
    uint32_t v_max, a_max, path; ///< [LSB] bounds of |v| and |a|; path: TABLE_FORMAT.md
} cam_entry_t;
_Static_assert(sizeof(cam_entry_t) == cam_table_entry_size, "as in the format");

/// Bounds of a table's quintics and of their derivatives, between the knots too. Value, first and
/// third derivative are bounded by their Bernstein coefficients. The second derivative is evaluated
/// at 32nds of every interval, and the largest deviation between them is added. The range of a
/// channel's values is found from the coefficients on the eighths of every interval, in whole
/// multiples of 1/327 680 LSB, so that the tools, which write the header, find exactly the same
/// numbers. Between two slices the knots are blended linearly, so the values there are between
/// those of the slices. Source: TABLE_FORMAT.md, "The range of values"; MATHS.md (51); Farouki,
/// "The Bernstein polynomial basis: a centennial retrospective", CAGD 29 (2012).

/// Largest magnitudes so far, in the LSB of the knots and per knot interval; starts with zeros.
/// Scaled so that no segment needs a division.
typedef struct {
    int64_t tenfold;     ///< value, times 10
    int64_t twice;       ///< first derivative, times 2
    int64_t second_8192; ///< second derivative, times 8192
    int64_t third;       ///< third derivative
} cam_bounds_t;

/// Widen the bounds of value and first derivative by the quintic between two knots. A bound is at
/// most 8/3 of the true maximum, a few per cent above it where the knots follow a smooth function.
void cam_bounds_add(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// Widen the bound of the second derivative by the quintic between two knots: within 1 % of the
/// true maximum, even next to a knot at which the third derivative jumps.
void cam_bounds_add_second(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// The third derivative jumps at the knots.
void cam_bounds_add_third(cam_bounds_t *b, const cam_wide_knot_t *k0, const cam_wide_knot_t *k1);

/// A range of values in the unit of a channel.
typedef struct {
    int64_t low, high;
} cam_extent_t;

/// @param p_min, p_max  [LSB] bounds of the values of the knots
/// @return              their range plus an LSB for the evaluation's rounding, rounded outwards
cam_extent_t cam_extent_of_knots(const cam_channel_t *ch, int64_t p_min, int64_t p_max);

/// Widen a range to all values that cam_eval.h returns for a channel, with an LSB for its rounding.
/// @param ch         its knots keep the bounds of the format
/// @param is_around  it is over angle: the knot after the last of a slice is the first
/// @param known      [unit] initial range: the guaranteed one, or that of the knots
/// @return           the smallest range of whole units that holds `known` and all values
/// Cost: six sums per knot, and near an end of the range 7 halvings; TABLE_FORMAT.md has figures.
cam_extent_t cam_extent_widened(const cam_channel_t *ch, bool is_around, cam_extent_t known);

/// Check of one channel: its entry in the directory, and its data. Source: TABLE_FORMAT.md,
/// "Channel entry", "Knots", "Passes", "The bound that makes overflow impossible".

/// Check an entry and all its knots.
/// @param t     its image, range of heights and lobes
/// @param used  [bytes] end of the preceding data in the image; advanced past this channel
/// @return      cam_ok, or the first error in the order entry, layout, heights, knots
CAM_MUST_USE cam_err_t cam_entry_check(const cam_entry_t *e, const cam_table_t *t, uint64_t *used);

/// Check an entry of at most `most` records: 0 in all fields that describe knots, and the heights
/// of the table.
CAM_MUST_USE cam_err_t cam_entry_check_records(const cam_entry_t *e, uint32_t most, size_t size,
                                               const cam_table_t *t, uint64_t *used);

/// Check the entry of the passes and its records, and put them into the table.
CAM_MUST_USE cam_err_t cam_entry_check_passes(const cam_entry_t *e, uint64_t *used, cam_table_t *t);

/// @return whether values are valid for the entry's kind: a speed ratio between 1/16 and 4, an
///         angle within a quarter turn to either side; lengths are not limited here
bool cam_entry_is_in_unit(const cam_entry_t *e, cam_extent_t values);

/// @return false: of height alone
bool cam_entry_is_over_angle(const cam_entry_t *e);

/// Knots or records, and channel, of an entry whose layout has been checked.
const void *cam_entry_data(const cam_entry_t *e, const cam_table_t *t);
cam_channel_t cam_entry_channel(const cam_entry_t *e, const cam_table_t *t);

/// Check that a way begins and ends with 0 and that Z rises everywhere (with stations: stays
/// between its first and its last height), and fill in way_slope_ppm and way_bend_ppm_per_mm, those
/// of a plain helix without a way. Four evaluations per knot.
/// @return cam_ok or cam_err_image_channel
CAM_MUST_USE cam_err_t cam_feed_profile_check(cam_table_t *table);

/// Check the entry and the directory of lobes, and put them into the table.
CAM_MUST_USE cam_err_t cam_lobes_check(const cam_entry_t *e, uint64_t *used, cam_table_t *table);

/// Check, once all channels are known, that every channel over angle has all patterns.
CAM_MUST_USE cam_err_t cam_lobes_check_patterns(const cam_table_t *table);

/// Bounds of a channel's motion that the format does not store, and the check of those that the
/// header of a table with a speed channel guarantees. The bounds of a channel over angle hold
/// between the knots too. They exceed the largest values by at most two per cent where the knots
/// are as dense as a tolerance of 1e-4 degrees makes them. One pass over the knots.

/// All bounds: of a channel whose knots have been checked, over all angles and slices, rounded up,
/// saturated.
cam_swing_peaks_t cam_peaks_of_swing(const cam_channel_t *ch);

/// @return [nm/rad3] bound of the third derivative of u: its jerk over the cube of the spindle
/// speed
uint32_t cam_peaks_third(const cam_channel_t *ch);

/// @return [nm/rad2] rms of the second derivative over a turn, from its values at the knots
uint32_t cam_peaks_rms_second(const cam_channel_t *ch);

/// @return change over height: linear between slices, with a kink at each
cam_change_t cam_peaks_of_change(const cam_channel_t *ch);

/// Largest slope and curvature of a channel over height, saturated at UINT32_MAX.
typedef struct {
    uint32_t slope_ppm;       ///< [1e-6] magnitude of the slope
    uint32_t rise_ppm;        ///< [1e-6] largest slope; 0 where none is above 0
    uint32_t bend_ppm_per_mm; ///< [1e-6 / mm] magnitude of the second derivative
} cam_x_slope_t;

/// Measure the slope and curvature that X and Z must be able to follow.
/// @param x  a channel over height alone whose knots have been checked
/// @return   from samples at quarters of the slice spacing; a peak of a function f between samples
///           is missed by at most (spacing / 8)^2 / 2 times the largest |f''|
cam_x_slope_t cam_x_slope_of(const cam_channel_t *x);

/// Bound the demand of a speed channel on the spindle's speed loop. A first-order loop with time
/// constant T follows the ratio r of a mean speed m if its set-point m (r + c r r'), c = m T, stays
/// between 0 and the highest speed. It is not negative where -r' c <= 1. Source: MATHS.md (80).
/// @param ch  kind speed, its knots checked; absent: the ratio is 1
/// @return    largest values at the knots, rounded up
cam_spindle_demand_t cam_peaks_of_speed(const cam_channel_t *ch);

/// Check that with r and r' of the speed channel, |u' r| and |u'' r^2 + u' r r'| do not exceed
/// their limits at any knot of u, nor |r r'| its limit at any knot of speed. Rounding accepts an
/// excess below 1/2048. One evaluation of the speed for each knot.
/// @param t  checked channels u and speed, and the three peaks of the header
/// @return   cam_ok or cam_err_image_limits
CAM_MUST_USE cam_err_t cam_peaks_check(const cam_table_t *t);

#endif
