// SPDX-License-Identifier: Apache-2.0
/// sim_cubics: a piecewise cubic over height, clamped outside.
#ifndef SIM_CUBICS_H
#define SIM_CUBICS_H

#include <stddef.h> // size_t

/// ((c[0] s + c[1]) s + c[2]) s + c[3] with s = z - break[i].
typedef struct {
    double *break_mm; ///< n + 1, rising
    double (*c)[4];   ///< n, highest power first
    size_t n;
    size_t i_last; ///< piece of the last look-up: the next one is near
} sim_cubics_t;

/// @param breaks  n + 1 rising numbers
/// @param i       piece to start from
/// @return        piece that holds v, 0 .. n - 1; the first or last one for v outside
size_t sim_piece_of(const double *breaks, size_t n, size_t i, double v);

/// @param z_mm  any
double sim_cubics_at(sim_cubics_t *p, double z_mm);

void sim_cubics_free(sim_cubics_t *p);

#endif
