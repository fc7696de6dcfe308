// SPDX-License-Identifier: Apache-2.0
#include "compare_surface.h"
#include <math.h> // sin, cos, sqrt

#define TWO_PI 6.28318530717958647693

void compare_profile(double z_nm, double x[3])
{
    const double above_nm = z_nm - 20e6;
    x[0] = 46e6 - 7.5e-11 * above_nm * above_nm;
    x[1] = -1.5e-10 * above_nm;
    x[2] = -1.5e-10;
}

static double oval_nm(double z_nm)
{
    return z_nm < 20e6 ? 150e3 + z_nm * (50e3 / 20e6) : 200e3 + (z_nm - 20e6) * (100e3 / 42e6);
}

void compare_surface(double theta, double z_nm, double u[3])
{
    double x[3];
    compare_profile(z_nm, x);
    const double a = x[0];
    const double b = a - oval_nm(z_nm) / 2.0;
    const double k = (a - b) * (a + b) / (b * b);
    const double s = sin(theta);
    const double c = cos(theta);
    const double w = 1.0 + k * s * s;
    const double w1 = 2.0 * k * s * c;
    const double w2 = 2.0 * k * (c * c - s * s);
    const double q = sqrt(w);
    u[0] = a * k * s * s / (q * (q + 1.0));
    u[1] = a * w1 / (2.0 * w * q);
    u[2] = a * (w2 / (2.0 * w * q) - 0.75 * w1 * w1 / (w * w * q));
}

void compare_reference(uint32_t theta_q32, int32_t z_nm, double u[3])
{
    const int32_t above_nm = z_nm < 0 ? 0 : z_nm;
    const int32_t in_nm = above_nm > compare_z_last_nm ? compare_z_last_nm : above_nm;
    compare_surface(theta_q32 * (TWO_PI / 4294967296.0), in_nm, u);
}
