// SPDX-License-Identifier: Apache-2.0
/// fixture_reference: the quintics of TABLE_FORMAT.md in long double, knot by knot.
#ifndef FIXTURE_REFERENCE_H
#define FIXTURE_REFERENCE_H

#include "cam/cam_table.h" // cam_channel_t

/// Value and derivatives per knot interval, in LSB.
typedef struct {
    long double y, d1, d2;
} fixture_value_t;

/// @param weight  of slice i + 1, 0 .. 1
fixture_value_t fixture_reference_surface(const cam_channel_t *ch, uint32_t theta_q32, uint32_t i,
                                          long double weight);
/// Weight from the height itself, clamped, without the stored reciprocal.
fixture_value_t fixture_reference_surface_at(const cam_channel_t *ch, uint32_t theta_q32,
                                             int32_t z_nm);
/// @param t  place between knots i and i + 1, 0 .. 1
fixture_value_t fixture_reference_profile(const cam_channel_t *ch, uint32_t i, long double t);

#endif
