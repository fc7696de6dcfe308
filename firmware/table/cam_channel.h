// SPDX-License-Identifier: Apache-2.0
/// cam_channel: what a table is made of once it has been checked: knots, channels, bounds.
///
/// Types only; cam_table.h fills them in. The format of the image is TABLE_FORMAT.md.
#ifndef CAM_CHANNEL_H
#define CAM_CHANNEL_H

#include <stdbool.h> // bool
#include <stddef.h>  // NULL
#include <stdint.h>  // int32_t, uint32_t

enum {
    cam_table_header_size = 128,
    cam_table_entry_size = 64,
    cam_table_max_channels = 8,
    cam_table_name_size = 32,
    cam_table_max_slices = 4096,
};

/// One in the unit of a speed ratio.
#define CAM_TABLE_RATIO_ONE (INT32_C(1) << 20)

/// A quarter turn in the unit of an angle channel, 2^-26 turn; no angle is larger.
#define CAM_TABLE_ANGLE_MAX (INT32_C(1) << 24)

/// Bound of the three sums of TABLE_FORMAT.md, in LSB. With four guard bits the evaluation stays
/// below 2^30: 16 * (2^25 - 1) for a sum, twice that for a difference of slices.
#define CAM_TABLE_SUM_MAX ((INT32_C(1) << 25) - 1)

/// Knot of a quintic segment, in the LSB of its channel, h = one knot interval.
typedef struct {
    int32_t p; ///< value
    int32_t v; ///< first derivative * h
    int32_t a; ///< second derivative * h^2 / 2
} cam_knot_t;

/// A channel: a function of angle and height (u, speed, angle), or of height alone (x: one knot per
/// slice). Values of u and x count nanometres, those of speed 2^-20 of the mean speed, those of
/// angle 2^-26 turn.
typedef struct {
    const cam_knot_t *knots;    ///< [n_slices][1 << log2_knots], inside the image
    uint32_t n_slices;          ///< 2 .. 4096
    uint32_t log2_knots;        ///< u, speed, angle: 2 .. 12; x: 0
    uint32_t log2_repeat;       ///< patterns per turn, 0 .. 4; x: 0
    uint32_t frac_bits;         ///< LSB = 2^-frac_bits nm, 0 .. 8
    int32_t z_first_nm;         ///< [nm] height of slice 0
    uint32_t span_nm;           ///< [nm] height of the last slice above slice 0
    uint32_t slices_per_nm_q48; ///< [slices/nm] >= 2^24
    int32_t offset_nm;          ///< [nm] value at p = 0
} cam_channel_t;

/// Bounds of what a table demands of the tool's swing, at the full amplitude.
typedef struct {
    uint32_t most_mdeg;            ///< [degrees / 1000] to either side
    uint32_t first_mdeg_per_rad;   ///< [degrees / 1000 / rad] speed over speed of the spindle
    uint32_t second_mdeg_per_rad2; ///< [degrees / 1000 / rad2] acceleration over its square
} cam_swing_peaks_t;

/// Bounds of how a channel changes over height, in its unit and per slice.
typedef struct {
    uint32_t most;    ///< difference of two neighbouring slices
    uint32_t per_rad; ///< ... of their slopes over the angle
    uint32_t kink;    ///< ... of two neighbouring differences
} cam_change_t;

/// A checked table. All members are read-only after cam_table_check().
typedef struct {
    cam_channel_t u;                ///< radius reduction, positive towards the axis
    cam_channel_t x;                ///< long half axis
    cam_channel_t speed;            ///< speed ratio; knots == NULL: the speed is uniform
    cam_channel_t angle;            ///< of a cam, normal at the contact; knots == NULL: a skirt
    bool is_swung;                  ///< the tool must swing by `angle`
    bool is_ring_helix;             ///< a geared Z follows a ring-helix (cam_feed.h), not a helix
    cam_swing_peaks_t swing;        ///< of the swing at uniform speed; 0 without one
    cam_change_t u_change;          ///< [nm] of u over height, at every angle
    cam_change_t swing_change;      ///< [turn / 2^26] of the swing; 0 without one
    char name[cam_table_name_size]; ///< printable ASCII, zero-terminated
    int32_t z_first_nm, z_last_nm;  ///< [nm] served range of heights
    int32_t direction;              ///< +1 or -1: spindle sense while cutting, +1 is M3
    uint32_t spindle_mrpm;          ///< [r/min / 1000] of the part
    uint32_t feed_nm;               ///< [nm] per turn
    uint32_t depth_nm;              ///< [nm] at the long axis
    uint32_t limit_u_stroke_nm;     ///< [nm] peak to peak, of the machine that it was made for
    uint32_t limit_u_speed_um_s;    ///< [um/s]
    uint32_t limit_u_acceleration_mm_s2; ///< [mm/s2]
    uint32_t limit_spindle_mrpm;         ///< [r/min / 1000]
    int32_t u_min_nm, u_max_nm;          ///< [nm] bounds of u over the whole table
    uint32_t u1_peak_nm_per_rad;         ///< [nm/rad] bound of |u' r|: speed of U / mean speed
    uint32_t u2_peak_nm_per_rad2;        ///< [nm/rad2] bound of |u'' r^2 + u' r r'|
    uint32_t spindle_peak_ppm;           ///< [1e-6 / rad] bound of |r r'|; 0: uniform
    uint32_t ratio_max_q20;              ///< [2^-20] bound of r; 2^20: uniform
    uint32_t x_slope_ppm;                ///< [1e-6] largest |dX/dZ|, measured by the check
    uint32_t x_bend_ppm_per_m;           ///< [1e-6 / m] largest |d2X/dZ2|, measured too
    uint32_t error_pm;                   ///< [pm] error that the generator measured
    uint32_t crc32;                      ///< of the image
    const void *image;                   ///< start of the image
    uint32_t image_size;                 ///< [bytes]
} cam_table_t;

/// A cam rises above its base circle, on which u is 0, by this: what leaves its work goes so much
/// further. The largest amplitude that a parameter allows is in it.
/// @return [nm] 0 of a skirt
static inline int32_t cam_table_rise_nm(const cam_table_t *table)
{
    const bool is_risen = table->angle.knots != NULL && table->u_min_nm < 0;
    return is_risen ? -(table->u_min_nm + table->u_min_nm / 4) : 0;
}

#endif
