// SPDX-License-Identifier: Apache-2.0
/// fixture_image: table images made in C from TABLE_FORMAT.md, independent of tools/mktables.
#ifndef FIXTURE_IMAGE_H
#define FIXTURE_IMAGE_H

#include "cam/cam_table.h" // cam_knot_t
#include <stdbool.h>       // bool
#include <stddef.h>        // size_t
#include <stdint.h>        // uint32_t

/// Offsets in the header.
enum {
    fixture_at_magic = 0,
    fixture_at_order = 8,
    fixture_at_version = 12,
    fixture_at_image_size = 16,
    fixture_at_crc = 20,
    fixture_at_header_size = 24,
    fixture_at_n_channels = 28,
    fixture_at_name = 32,
    fixture_at_z_first = 64,
    fixture_at_z_last = 68,
    fixture_at_direction = 72,
    fixture_at_spindle = 76,
    fixture_at_feed = 80,
    fixture_at_depth = 84,
    fixture_at_limit_stroke = 88,
    fixture_at_limit_speed = 92,
    fixture_at_limit_acceleration = 96,
    fixture_at_limit_spindle = 100,
    fixture_at_u_min = 104,
    fixture_at_u_max = 108,
    fixture_at_u1_peak = 112,
    fixture_at_u2_peak = 116,
    fixture_at_error = 120,
    fixture_at_spindle_peak = 124,
};

/// Offsets in a channel entry.
enum {
    fixture_in_kind = 0,
    fixture_in_offset = 4,
    fixture_in_size = 8,
    fixture_in_n_slices = 12,
    fixture_in_log2_knots = 16,
    fixture_in_log2_repeat = 20,
    fixture_in_frac_bits = 24,
    fixture_in_z_first = 28,
    fixture_in_z_last = 32,
    fixture_in_reciprocal = 36,
    fixture_in_offset_nm = 40,
    fixture_in_p_min = 44,
    fixture_in_p_max = 48,
    fixture_in_v_max = 52,
    fixture_in_a_max = 56,
    fixture_in_path = 60,
};

/// Places in the directory; that of the swing where there is no speed channel.
enum { fixture_u = 0, fixture_x = 1, fixture_speed = 2, fixture_swing = 2 };

enum { fixture_image_capacity = 1 << 19 };

/// An image with room to grow; 32-byte aligned.
typedef struct {
    _Alignas(32) uint8_t bytes[fixture_image_capacity];
    size_t size;
} fixture_image_t;

/// u [nm] over angle [rad] and height [nm]: value, first and second derivative to the angle.
typedef void fixture_surface_fn(double theta, double z_nm, double u[3]);
/// x [nm] over height [nm]: value, first and second derivative.
typedef void fixture_profile_fn(double z_nm, double x[3]);

/// What an image is made from.
typedef struct {
    uint32_t n_slices, log2_knots, log2_repeat, frac_bits; ///< of u
    uint32_t n_x, x_frac_bits;                             ///< of x
    int32_t u_offset_nm, x_offset_nm;
    int32_t z_first_nm, z_last_nm, direction;
    uint32_t spindle_mrpm, feed_nm;
    fixture_surface_fn *u;
    fixture_profile_fn *x;
    bool is_ring_helix;
    fixture_surface_fn *speed; ///< NULL: no speed channel; 32 knots, two patterns, 3 slices
    fixture_surface_fn *swing; ///< [rad] NULL: no swing; knots as of the speed
} fixture_part_t;

/// @return 1 mm of a skirt, 10 turns at 0.1 mm, 2500 r/min, cosine oval 0.2 .. 0.3 mm, 4224 bytes
fixture_part_t fixture_part_short(void);

/// @return the short skirt with a speed channel of fixture_ratio()
fixture_part_t fixture_part_modulated(void);

/// @return the short skirt's heights, a cam of 0.1 mm lift with a swing of fixture_gamma()
fixture_part_t fixture_part_swung(void);

/// @return the smallest image that is accepted: 2 slices of 4 knots, 2 knots of x, 384 bytes
fixture_part_t fixture_part_smallest(void);

/// The ovals of the two parts: G/4 (1 - cos 2 theta), G rising from 0.2 to 0.3 mm in 1 mm.
void fixture_cosine_oval(double theta, double z_nm, double u[3]);
/// A speed ratio like that of equal-volume turning: 1.5 at the long axis, 0.75 at the short one,
/// less with height.
void fixture_ratio(double theta, double z_nm, double r[3]);
/// The swing of a cam in rad: 0.35 sin 2 theta at the bottom, less with height.
void fixture_gamma(double theta, double z_nm, double g[3]);
/// Exact ellipse of maths.md 1.1: a = 46 mm, G = 0.2 mm, at every height.
void fixture_ellipse(double theta, double z_nm, double u[3]);

/// Write a complete, sealed image.
void fixture_image_make(fixture_image_t *image, const fixture_part_t *part);

uint32_t fixture_image_get(const fixture_image_t *image, size_t at);
void fixture_image_put(fixture_image_t *image, size_t at, uint32_t value);
/// @return where a field of a channel's entry lies
size_t fixture_image_in(uint32_t channel, size_t field);
/// @return knots of a channel
cam_knot_t *fixture_image_knots(fixture_image_t *image, uint32_t channel);
/// @return number of knots of a channel
uint32_t fixture_image_n_knots(const fixture_image_t *image, uint32_t channel);

/// Bounds of the entry (and the promises of the header for u) from the knots as they are now.
void fixture_image_remeasure(fixture_image_t *image, uint32_t channel);
/// CRC-32 over what is there now.
void fixture_image_seal(fixture_image_t *image);

#endif
