// SPDX-License-Identifier: Apache-2.0
#include "sim_json.h"
#include "sim_units.h" // sim_clamp
#include <stdlib.h>    // free

size_t sim_piece_of(const double *breaks, size_t n, size_t i, double v)
{
    while (i > 0u && v < breaks[i]) {
        i--;
    }
    while (i + 1u < n && v >= breaks[i + 1u]) {
        i++;
    }
    return i;
}

double sim_cubics_at(sim_cubics_t *p, double z_mm)
{
    const double z = sim_clamp(z_mm, p->break_mm[0], p->break_mm[p->n]);
    p->i_last = sim_piece_of(p->break_mm, p->n, p->i_last, z);
    const double s = z - p->break_mm[p->i_last];
    const double *c = p->c[p->i_last];
    return ((c[0] * s + c[1]) * s + c[2]) * s + c[3];
}

void sim_cubics_free(sim_cubics_t *p)
{
    free(p->break_mm);
    free(p->c);
    *p = (sim_cubics_t){0};
}
