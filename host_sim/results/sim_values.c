// SPDX-License-Identifier: Apache-2.0
#include "sim_values.h"
#include <stdlib.h> // realloc, free
#include <string.h> // strlen

enum { first_room = 1 << 14 };

void sim_values_char(sim_values_t *v, char c)
{
    const size_t n = v->has_header ? sim_values_header : strlen(v->header);
    if (c == '\n') {
        v->has_header = true;
    } else if (n + 1u < sim_values_header) {
        v->header[n] = c;
    }
}

static bool make_room(sim_values_t *v)
{
    if (v->n < v->room) {
        return true;
    }
    const size_t room = v->room > 0u ? 2u * v->room : first_room;
    double *value = realloc(v->value, room * sizeof *value);
    if (value == NULL) {
        v->is_lost = true;
        return false;
    }
    v->value = value;
    v->room = room;
    return true;
}

void sim_values_add(sim_values_t *v, int64_t mantissa, int decimals)
{
    static const double power[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    if (make_room(v)) {
        v->value[v->n++] = (double)mantissa / power[decimals];
    }
}

void sim_values_free(sim_values_t *v)
{
    free(v->value);
    *v = (sim_values_t){0};
}
