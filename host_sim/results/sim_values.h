// SPDX-License-Identifier: Apache-2.0
/// sim_values: an output table as numbers in memory instead of text in a file.
///
/// An output writes its header line, then rows of columns. Text rounds each number to the decimals
/// of its column; this module keeps that decimal, correctly rounded to a double, which is bit for
/// bit what a reader of the file gets while the digits without the point are below 2^53.
#ifndef SIM_VALUES_H
#define SIM_VALUES_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // int64_t

enum { sim_values_header = 2048 };

typedef struct {
    char header[sim_values_header]; ///< names of the columns, separated by commas
    bool has_header;                ///< the header is complete
    double *value;                  ///< row after row
    size_t n, room;
    bool is_lost; ///< out of memory: values are missing
} sim_values_t;

/// Append a character of the header line; later characters are separators and are dropped.
void sim_values_char(sim_values_t *v, char c);

/// Append mantissa / 10^decimals. @param decimals  0 .. 9
void sim_values_add(sim_values_t *v, int64_t mantissa, int decimals);

/// Free the numbers; *v can be reused.
void sim_values_free(sim_values_t *v);

#endif
