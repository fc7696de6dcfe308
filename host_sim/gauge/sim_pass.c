// SPDX-License-Identifier: Apache-2.0
#include "sim_removal.h"
#include "sim_units.h" // sim_floor
#include <assert.h>    // static_assert
#include <stdint.h>    // int64_t, uint32_t

static uint32_t wrapped(int64_t place)
{
    static_assert(UINT32_MAX % sim_pass_kept == sim_pass_kept - 1, "a power of 2");
    return (uint32_t)place % sim_pass_kept;
}

/// @return [mm] height of the last pass at an angle, a turn ago
static double before_mm(const sim_pass_t *p, double turn)
{
    const double at = (turn - 1.0) * sim_pass_places;
    const int64_t place = sim_floor(at);
    const double part = at - (double)place;
    return (1.0 - part) * p->z_mm[wrapped(place)] + part * p->z_mm[wrapped(place + 1)];
}

/// Record the heights at all angles passed since the last sample.
static void note(sim_pass_t *p, double turn, double z_mm)
{
    const int64_t end = sim_floor(turn * sim_pass_places);
    int64_t place = sim_floor(p->turn * sim_pass_places) + 1;
    place = end - place < sim_pass_kept ? place : end - sim_pass_kept + 1;
    const double rise = (z_mm - p->last_z_mm) / (turn - p->turn);
    for (; place <= end; place++) {
        p->z_mm[wrapped(place)] = p->last_z_mm + rise * ((double)place / sim_pass_places - p->turn);
    }
}

double sim_pass_touch(sim_pass_t *p, double turn, double z_mm)
{
    if (!p->is_begun) {
        p->is_begun = true;
        p->turn = turn;
        p->last_z_mm = z_mm;
        for (int i = 0; i < sim_pass_kept; i++) {
            p->z_mm[i] = z_mm;
        }
    }
    const double thick_mm = z_mm - before_mm(p, turn);
    if (turn > p->turn) {
        note(p, turn, z_mm);
        p->turn = turn;
        p->last_z_mm = z_mm;
    }
    return thick_mm > 0.0 ? thick_mm : 0.0;
}
