// SPDX-License-Identifier: Apache-2.0
/// cam_table: the table of a part: its image, the check of an image, and what the check finds.
///
/// An image (TABLE_FORMAT.md) is made by mktables: a header and one channel of knots for each
/// function of spindle angle and height. The check treats it as untrusted bytes and fills a
/// cam_table_t that points into it; the interrupt reads the image in place (cam_eval.h).
///
/// Read the sizes of the format, then knot and channel, then the members of cam_table_t, last the
/// functions. "cam" is the name of this project; a part with cam lobes is called a lobe here, any
/// other part (a piston, a ring) a skirt. Context of all functions: slow side.
#ifndef CAM_TABLE_H
#define CAM_TABLE_H

#include "cam_err.h" // cam_err_t
#include <stdbool.h> // bool
#include <stddef.h>  // NULL, size_t
#include <stdint.h>  // int32_t, uint32_t

/// Sizes in bytes and largest counts of the format.
enum {
    cam_table_header_size = 128,
    cam_table_entry_size = 64,
    cam_table_max_channels = 8,
    cam_table_name_size = 32,
    cam_table_max_slices = 4096,
    cam_table_max_passes = 16,
    cam_table_max_mrpm = 60000000,    ///< [r/min / 1000] the range of the parameter spindle_mrpm
    cam_table_max_feed_nm = 10000000, ///< [nm] the range of the parameter feed_nm
    cam_table_max_lobes = 64,
};

/// The ratio 1 in the unit of a speed channel, 2^-20 of the mean speed.
#define CAM_TABLE_RATIO_ONE (INT32_C(1) << 20)

/// A quarter turn in the unit of an angle channel, 2^-26 turn. No angle of a table is larger.
#define CAM_TABLE_ANGLE_MAX (INT32_C(1) << 24)

/// [LSB] bound of the three sums of TABLE_FORMAT.md, "The bound". With four guard bits a sum stays
/// below 16 * 2^25 = 2^29 and a difference of two slices below 2^30, so int32 holds both.
#define CAM_TABLE_SUM_MAX ((INT32_C(1) << 25) - 1)

/// A knot: value and two derivatives in the LSB of the channel. h is the distance to the next knot.
/// Two neighbouring knots define the quintic between them.
typedef struct {
    int32_t p; ///< value
    int32_t v; ///< first derivative * h
    int32_t a; ///< second derivative * h^2 / 2
} cam_knot_t;

/// A channel: a function of angle and height (u, speed, angle), or of height alone (x, with one
/// knot per slice). The unit of its values depends on its kind: nm for u and x, 2^-20 of the mean
/// speed for speed, 2^-26 turn for angle. The LSB of the knots is the unit times 2^-frac_bits.
typedef struct {
    const cam_knot_t *knots;    ///< [n_slices][1 << log2_knots], inside the image; NULL: absent
    uint32_t n_slices;          ///< 2 .. 4096
    uint32_t log2_knots;        ///< u, speed, angle: 2 .. 12; x: 0
    uint32_t log2_repeat;       ///< the pattern is repeated 2^this times per turn, 0 .. 4; x: 0
    uint32_t frac_bits;         ///< LSB = unit of the channel * 2^-frac_bits, 0 .. 8
    int32_t z_first_nm;         ///< [nm] height of slice 0
    uint32_t span_nm;           ///< [nm] height of the last slice above slice 0
    uint32_t slices_per_nm_q48; ///< [slices/nm / 2^48] reciprocal of the spacing, >= 2^24
    int32_t value_offset;       ///< [unit of the channel] value at p = 0
} cam_channel_t;

/// A lobe, as the image holds it: its position on the shaft and the pattern that it plays.
typedef struct {
    int32_t z_first_nm, z_last_nm; ///< [nm]
    uint32_t phase_q32;            ///< [turn / 2^32] spindle angle at which the pattern begins
    uint32_t pattern;              ///< slice of all channels over angle
    uint32_t changes_per_nm_q48;   ///< [1/nm / 2^48] reciprocal of the height over which the lift
                                   ///< falls to 0 above the lobe and rises below the next one
} cam_lobe_t;

/// A pass, as the image holds it.
typedef struct {
    int32_t allowance_nm;  ///< [nm] stock that it leaves on the radius
    uint32_t feed_nm;      ///< [nm] feed per turn; its mean with a way
    uint32_t spindle_mrpm; ///< [r/min / 1000]
    uint32_t reserved;     ///< 0
} cam_pass_t;

/// Upper bounds of the motion that a table demands of the tool's swing, at full amplitude.
typedef struct {
    uint32_t most_mdeg;            ///< [degrees / 1000] angle to either side
    uint32_t first_mdeg_per_rad;   ///< [degrees / 1000 / rad] |swing'|: speed over spindle speed
    uint32_t second_mdeg_per_rad2; ///< [degrees / 1000 / rad2] |swing''|
} cam_swing_peaks_t;

/// Upper bounds of a channel's change from slice to slice, in the unit of the channel: they bound
/// the motion that the feed along Z adds.
typedef struct {
    uint32_t most;    ///< difference of two neighbouring slices at the same angle
    uint32_t per_rad; ///< [1/rad] difference of their slopes over the angle
    uint32_t kink;    ///< jump of the difference at a slice
} cam_change_t;

/// Speed times time constant at which the set-point of a speed loop is bounded: k^2 / 128 <= 8 rad.
enum { cam_spindle_demand_places = 33, cam_spindle_demand_per_rad = 128 };

/// Demand of a speed channel on the spindle's speed loop (cam_peaks_set_point_q20()).
typedef struct {
    uint32_t fall_ppm_per_rad; ///< [1e-6 / rad] largest -r': bandwidth over mean speed
    uint32_t set_q20[cam_spindle_demand_places]; ///< [2^-20] largest r + c r r' at these c
    uint32_t rise_q20;                           ///< [2^-20 / rad] largest r r'
} cam_spindle_demand_t;

/// A checked table. All members are read-only after cam_table_check().
typedef struct {
    cam_channel_t u;     ///< radius reduction, positive towards the axis
    cam_channel_t x;     ///< long half axis
    cam_channel_t speed; ///< speed ratio; knots == NULL: the speed is uniform
    cam_channel_t angle; ///< of a lobe, whose u is minus its lift: normal at the contact; knots ==
                         ///< NULL: a skirt
    cam_channel_t way;   ///< lead of Z over a plain helix; knots == NULL: 0
    bool has_stations;   ///< Z may stand and go back; all else is found on the plain helix
    const cam_pass_t *passes;  ///< in the order of cutting; NULL: one, as the header has it
    uint32_t n_passes;         ///< 1 .. 16; 0 without passes
    const cam_lobe_t *lobes;   ///< rising; NULL: slices are heights, not patterns
    uint32_t n_lobes;          ///< 1 .. 64; 0 without lobes
    uint32_t least_change_nm;  ///< [nm] height of the shortest change between lobes; 0: none
    bool is_swung;             ///< the tool must swing by `angle` (kind 4)
    bool is_ring_helix;        ///< a geared Z follows a ring-helix (cam_motion.h), not a helix
    cam_swing_peaks_t swing;   ///< of the swing at uniform speed; all 0 without a swing
    cam_change_t u_change;     ///< [nm] of u over height, at every angle
    cam_change_t swing_change; ///< [turn / 2^26] of the swing over height; 0 without a swing
    // The header of the image from its name on, in its order
    char name[cam_table_name_size];  ///< printable ASCII, zero-terminated
    int32_t z_first_nm, z_last_nm;   ///< [nm] range of heights that every channel serves
    int32_t direction;               ///< +1 (M3) or -1: sense of the spindle while cutting
    uint32_t spindle_mrpm;           ///< [r/min / 1000] the part's spindle speed
    uint32_t feed_nm;                ///< [nm] feed per turn
    uint32_t depth_nm;               ///< [nm] depth of cut at the long axis
    uint32_t limit_u_stroke_nm;      ///< [nm] peak to peak; limit_*: of the intended machine
    uint32_t limit_u_speed_um_per_s; ///< [um/s]
    uint32_t limit_u_acceleration_mm_per_s2; ///< [mm/s2]
    uint32_t limit_spindle_mrpm;             ///< [r/min / 1000] highest spindle speed
    int32_t u_min_nm, u_max_nm;              ///< [nm] bounds of u, between the knots too
    uint32_t u1_peak_nm_per_rad;       ///< [nm/rad] bound of |u' r|: speed of U over mean speed
    uint32_t u2_peak_nm_per_rad2;      ///< [nm/rad2] bound of |u'' r^2 + u' r r'|
    uint32_t error_pm;                 ///< [pm] of u and x against the exact geometry
    uint32_t spindle_peak_ppm_per_rad; ///< [1e-6 / rad] bound of |r r'|; 0: uniform speed
    uint32_t u3_peak_nm_per_rad3;      ///< [nm/rad3] bound of |u'''|, measured by the check
    uint32_t u2_rms_nm_per_rad2;       ///< [nm/rad2] rms of u'' over a turn, largest of all slices
    uint32_t ratio_max_q20;            ///< [2^-20] bound of the ratio r, between the knots too
    cam_spindle_demand_t spindle_demand; ///< demand of speed on the spindle's loop
    int32_t x_min_nm, x_max_nm;          ///< [nm] bounds of x, between the knots too
    uint32_t x_slope_ppm;                ///< [1e-6] largest |dX/dZ|, measured by the check
    uint32_t x_bend_ppm_per_mm;          ///< [1e-6 / mm] largest |d2X/dZ2|, measured too
    uint32_t way_slope_ppm;              ///< [1e-6] largest |dZ/dz| of the feed; helix: 10^6
    uint32_t way_bend_ppm_per_mm;        ///< [1e-6 / mm] largest change of that with the height
    uint32_t crc32;                      ///< of the image's bytes from 24 on
    const void *image;                   ///< start of the image
    uint32_t image_size;                 ///< [bytes] of the whole image
} cam_table_t;

/// Check an image and describe it.
/// @param image  bytes of an image, any content; must stay unchanged while *table is used
/// @param size   [bytes] of the image
/// @param table  filled on success, zeroed otherwise
/// @return       cam_ok, or the first error in the order of TABLE_FORMAT.md
/// Context: a few passes over the image, whose cost TABLE_FORMAT.md gives per byte.
CAM_MUST_USE cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table);

/// Compute a CRC-32 piece by piece.
/// @param crc   result of the previous piece; 0 for the first
/// @param data  n bytes
/// @return      CRC-32 of all pieces so far
/// Source: reflected polynomial 0xEDB88320 (ISO-HDLC, as in zlib).
uint32_t cam_crc32(uint32_t crc, const void *data, size_t n);

/// While engaging, the tool is at u = 0 before the amplitude rises, so a tool out of the work has
/// to be further away by the rise of the surface above u = 0: of a lobe above its base circle, of a
/// skirt above the radius about which its u swings.
/// @return [nm] that rise at 1.25, the largest amplitude; 0 where no u is below -1 (0, rounded
///         down)
static inline int32_t cam_table_rise_nm(const cam_table_t *table)
{
    return table->u_min_nm < -1 ? -(table->u_min_nm + table->u_min_nm / 4) : 0;
}

/// A knot, or a sum or difference of several; magnitudes below 2^40.
typedef struct {
    int64_t p, v, a;
} cam_wide_knot_t;

/// @param offset  [LSB] of the value
cam_wide_knot_t cam_bounds_wide(const cam_knot_t *knot, int64_t offset);

/// Put ten times the six Bernstein coefficients of the quintic between two knots.
void cam_bounds_tenfold(const cam_wide_knot_t *k0, const cam_wide_knot_t *k1, int64_t c[6]);

/// @param i  index of a knot of a channel over angle, counted over all slices
/// @return   index of the next knot of the same slice; the first follows the last
uint32_t cam_bounds_next(const cam_channel_t *ch, uint32_t i);

/// @param c_q16  [rad / 2^16] mean speed times time constant of the loop, below 2^40
/// @return       [2^-20] bound of r + c r r', the set-point over the mean speed; never falls with
///               rising c. The maximum of straight lines is convex, so the chord between two
///               measured c bounds it; beyond the last one the largest r r' does.
uint64_t cam_peaks_set_point_q20(const cam_spindle_demand_t *demand, uint64_t c_q16);

#endif
