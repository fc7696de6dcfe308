// SPDX-License-Identifier: Apache-2.0
/// sim_json: reads numbers from the report of a table. Every message names file and field.
#ifndef SIM_JSON_H
#define SIM_JSON_H

#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

// A piecewise cubic over height, constant beyond its ends.

/// On piece i the value is ((c[0] s + c[1]) s + c[2]) s + c[3] with s = z - break[i].
typedef struct {
    double *break_mm; ///< n + 1 rising heights
    double (*c)[4];   ///< n pieces, highest power first
    size_t n;
    size_t i_last; ///< piece of the last look-up, from which the next search starts
} sim_cubics_t;

/// Find the piece that contains v, stepping from piece i.
/// @param breaks  n + 1 rising numbers
/// @param i       piece to start from
/// @return        0 .. n - 1; the first or the last piece when v is outside
size_t sim_piece_of(const double *breaks, size_t n, size_t i, double v);

/// @param z_mm  any height
/// @return      the value there
double sim_cubics_at(sim_cubics_t *p, double z_mm);

void sim_cubics_free(sim_cubics_t *p);

// The report

/// The remedy when a report cannot be used.
#define SIM_JSON_REMEDY "make the table again with tools/mktables, or give --design"

enum { sim_json_max_pieces = 100000 };

/// Read one number. @return false when the item is not a finite number
bool sim_json_number(const cJSON *item, double *value);

/// Read a list of finite numbers.
/// @param values  allocated, for the caller to free; NULL on failure
/// @param n       number of values
/// @return        false when it is not such a list, or memory is short
bool sim_json_numbers(const cJSON *list, double **values, size_t *n);

/// Find an optional list of a report. @param where  dotted path of the parent, for messages
/// @return its number of entries, 0 when it is missing; -1 and *e when it is no list, or too long
int sim_json_count(const cJSON *parent, const char *where, const char *name, int most,
                   const char *path, common_error_t *e);

/// Read a list of two or more rising finite numbers.
/// @param n_pieces  one less than the count of numbers
bool sim_json_breaks(const cJSON *list, double **breaks, size_t *n_pieces);

/// Read parent.name as a piecewise cubic.
/// @param p      zero-initialised; the caller frees it, also on failure
/// @param where  dotted path of the parent, for messages
bool sim_json_cubics(sim_cubics_t *p, const cJSON *parent, const char *where, const char *name,
                     const char *path, common_error_t *e);

#endif
