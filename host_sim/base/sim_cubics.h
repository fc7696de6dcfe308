// SPDX-License-Identifier: Apache-2.0
/// sim_cubics: a piecewise cubic over height, constant beyond its ends.
#ifndef SIM_CUBICS_H
#define SIM_CUBICS_H

#include <stddef.h> // size_t

/// On piece i the value is ((c[0] s + c[1]) s + c[2]) s + c[3] with s = z - break[i].
typedef struct {
    double *break_mm; ///< n + 1 rising heights
    double (*c)[4];   ///< n pieces, highest power first
    size_t n;
    size_t i_last; ///< piece of the last look-up, from which the next search starts
} sim_cubics_t;

/// Find the piece that contains v, stepping from piece i.
/// @param breaks  n + 1 rising numbers
/// @param i       piece to start from
/// @return        0 .. n - 1; the first or the last piece when v is outside
size_t sim_piece_of(const double *breaks, size_t n, size_t i, double v);

/// @param z_mm  any height
/// @return      the value there
double sim_cubics_at(sim_cubics_t *p, double z_mm);

void sim_cubics_free(sim_cubics_t *p);

#endif
