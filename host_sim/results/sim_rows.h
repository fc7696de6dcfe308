// SPDX-License-Identifier: Apache-2.0
/// sim_rows: a table of results in memory, row after row of whole numbers.
///
/// The columns are a list "NAME:FORMAT,NAME:FORMAT,.." without blanks. FORMAT is a number of
/// decimals from 0 to 9 (the number 1234 with three decimals is 1.234), x4 or x8 for a mask of at
/// least so many hexadecimal digits, or s for a state by its number in cam_state.h. A name ends
/// with its unit.
#ifndef SIM_ROWS_H
#define SIM_ROWS_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // int64_t

enum { sim_rows_max_columns = 64 };

typedef struct {
    const char *columns; ///< NULL: not wanted
    int n_columns;
    char format[sim_rows_max_columns][2]; ///< first characters of each FORMAT
    int64_t *number;                      ///< of all rows
    size_t n, room;                       ///< numbers
    bool is_lost; ///< since the table was opened numbers went missing: out of memory
} sim_rows_t;

/// Begin a table. @param columns  kept, not copied
void sim_rows_open(sim_rows_t *t, const char *columns);

/// Append the next number of a row, in units of the column's last decimal.
void sim_rows_add(sim_rows_t *t, int64_t number);

/// Append the next number of a row, rounded to the column's decimals.
/// @param value  |value| * 10^decimals < 2^62
void sim_rows_real(sim_rows_t *t, double value);

/// Forget all rows, and keep their memory for others.
void sim_rows_drop(sim_rows_t *t);

/// Free the memory; *t is then as one that was never opened.
void sim_rows_free(sim_rows_t *t);

#endif
