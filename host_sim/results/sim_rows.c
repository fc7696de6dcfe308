// SPDX-License-Identifier: Apache-2.0
#include "sim_rows.h"
#include <math.h>   // floor
#include <stdlib.h> // realloc, free

enum { first_room = 1 << 12 };

void sim_rows_open(sim_rows_t *t, const char *columns)
{
    t->columns = columns;
    t->is_lost = false;
    t->n_columns = 0;
    for (const char *c = columns; *c != '\0'; c++) {
        if (*c == ':' && t->n_columns < sim_rows_max_columns) {
            t->format[t->n_columns][0] = c[1];
            t->format[t->n_columns][1] = c[2];
            t->n_columns++;
        }
    }
    sim_rows_drop(t);
}

void sim_rows_add(sim_rows_t *t, int64_t number)
{
    if (t->n == t->room) {
        const size_t room = t->room > 0u ? 2u * t->room : first_room;
        int64_t *larger = realloc(t->number, room * sizeof *larger);
        if (larger == NULL) {
            t->is_lost = true;
            return;
        }
        t->number = larger;
        t->room = room;
    }
    t->number[t->n++] = number;
}

void sim_rows_real(sim_rows_t *t, double value)
{
    static const double power[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    const int decimals = t->format[t->n % (size_t)t->n_columns][0] - '0';
    sim_rows_add(t, (int64_t)floor(value * power[decimals] + 0.5));
}

void sim_rows_drop(sim_rows_t *t)
{
    t->n = 0;
}

void sim_rows_free(sim_rows_t *t)
{
    free(t->number);
    *t = (sim_rows_t){0};
}
