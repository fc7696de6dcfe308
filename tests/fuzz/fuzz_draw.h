// SPDX-License-Identifier: Apache-2.0
/// fuzz_draw: a machine whose limits, gains and jerks are drawn by an input.
#ifndef FUZZ_DRAW_H
#define FUZZ_DRAW_H

#include "cam_param.h"  // cam_param_id_t
#include "fuzz_bytes.h" // fuzz_bytes_t
#include <stdint.h>     // int32_t

enum { fuzz_draw_n = 29, fuzz_draw_bytes = 2 * fuzz_draw_n }; ///< two bytes for each parameter

/// Set the parameters of the rig in state off. What is refused stays as it is.
void fuzz_draw_all(fuzz_bytes_t *b);

/// Write what draws a value, or one that is less by a ten-thousandth.
/// @param bytes  fuzz_draw_bytes that draw a machine; 0 draws the default
/// @param value  in the unit of the parameter; k2_us2 as a share of the square of k1
void fuzz_draw_write(uint8_t *bytes, cam_param_id_t id, double value);

#endif
