// SPDX-License-Identifier: Apache-2.0
/// compare_table: tables of compare_surface.h for each way of compare_eval.h, made on the core.
#ifndef COMPARE_TABLE_H
#define COMPARE_TABLE_H

#include "compare_eval.h" // compare_table_t

enum { compare_log2_knots = 3, compare_frac_bits = 8 }; ///< what tools/mktables chooses for 1 nm

/// Ours. @return a table over a checked image; asserts on an error
compare_table_t compare_table_ours(void);

/// The others, over memory of compare_table_release().
/// @param n_knots  of half a turn, 4 ..; with n_slices so many that the memory suffices
compare_table_t compare_table_linear(uint32_t n_knots);
compare_table_t compare_table_spline(uint32_t n_knots);
compare_table_t compare_table_quintic(uint32_t n_knots);

/// Free what the last table used.
void compare_table_release(void);

/// @return [bytes] of knots
uint32_t compare_table_bytes(const compare_table_t *t);

#endif
