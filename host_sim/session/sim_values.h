// SPDX-License-Identifier: Apache-2.0
/// sim_values: the table of an output as numbers in memory instead of text in a file.
///
/// An output writes its header line, then rows of columns. As text each number is rounded to the
/// decimals of its column; the number kept here is that decimal number, correctly rounded to a
/// double, so it is what a reader of the file gets, bit for bit, as long as the digits without the
/// point are below 2^53.
#ifndef SIM_VALUES_H
#define SIM_VALUES_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // int64_t

enum { sim_values_header = 2048 };

typedef struct {
    char header[sim_values_header]; ///< names of the columns, separated by commas
    bool has_header;                ///< its line is complete
    double *value;                  ///< row after row
    size_t n, room;
    bool is_lost; ///< there was no memory: values are missing
} sim_values_t;

/// Take a character of the header line; those behind it are separators and are dropped.
void sim_values_char(sim_values_t *v, char c);

/// Append mantissa / 10^decimals. @param decimals  0 .. 9
void sim_values_add(sim_values_t *v, int64_t mantissa, int decimals);

/// Free the numbers; *v can be filled again.
void sim_values_free(sim_values_t *v);

#endif
