// SPDX-License-Identifier: Apache-2.0
/// sim_correction: the correction of a drawing in a table, from a gauged part.
///
///     delta = sum over the orders k of  a_k(z) cos k phi + b_k(z) sin k phi
///
/// a_k and b_k are cubics over height, constant beyond their ends; phi is the drawing's angle. Only
/// the target of a report has a correction, never its design, which judges the part. MATHS.md
/// (160). Error: rounding.
#ifndef SIM_CORRECTION_H
#define SIM_CORRECTION_H

#include "common_error.h" // common_error_t
#include "sim_cubics.h"   // sim_cubics_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

enum { sim_correction_max_order = 64 };

typedef struct {
    double order; ///< a whole number, 1 .. sim_correction_max_order
    sim_cubics_t cos_mm, sin_mm;
} sim_wave_t;

typedef struct {
    sim_wave_t *wave; ///< NULL: none
    size_t n;
} sim_correction_t;

/// Read design.correction, if present.
/// @param c     zero-initialised; the caller frees it, also on failure
/// @param name  of the design, for messages
/// @param path  of the report, for messages
/// @return      false and *e when it is malformed
bool sim_correction_read(sim_correction_t *c, const cJSON *design, const char *name,
                         const char *path, common_error_t *e);

/// @param turn  [turn] drawing's angle, any
/// @param z_mm  any
/// @return      [mm] reduction of the radius, 0 without a correction
double sim_correction_delta_mm(sim_correction_t *c, double turn, double z_mm);

void sim_correction_free(sim_correction_t *c);

#endif
