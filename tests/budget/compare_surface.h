// SPDX-License-Identifier: Apache-2.0
/// compare_surface: the skirt on which evaluations are compared, exact, in double.
///
/// Like the Perkins 240 piston of tools/parts/perkins240.toml: ellipses whose long half axis is a
/// parabola about height 20 mm and whose ovality rises from 0.15 over 0.20 to 0.30 mm.
#ifndef COMPARE_SURFACE_H
#define COMPARE_SURFACE_H

#include <stdint.h> // int32_t

enum {
    compare_z_last_nm = 62000000,     ///< heights are 0 .. this
    compare_n_slices = 32,            ///< 2 mm apart: the bend of the ovality lies on one
    compare_log2_repeat = 1,          ///< an ellipse is the same after half a turn
    compare_largest_oval_nm = 300000, ///< diametral
};

/// u [nm] over angle [rad] and height [nm], first and second derivative to the angle.
/// Source: MATHS.md (2).
void compare_surface(double theta, double z_nm, double u[3]);

/// Long half axis [nm] over height [nm], first and second derivative.
void compare_profile(double z_nm, double x[3]);

/// u at a machine angle and a height that is clamped to the skirt.
void compare_reference(uint32_t theta_q32, int32_t z_nm, double u[3]);

#endif
