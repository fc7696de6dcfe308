// SPDX-License-Identifier: Apache-2.0
/// sim_json: numbers are read from the report of a table; every message names file and field.
#ifndef SIM_JSON_H
#define SIM_JSON_H

#include "sim_cubics.h"   // sim_cubics_t
#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

/// The remedy when a report cannot be used.
#define SIM_JSON_REMEDY "make the table again with tools/mktables, or give --design"

enum { sim_json_max_pieces = 100000 };

/// Read one number. @return false when the item is no finite number
bool sim_json_number(const cJSON *item, double *value);

/// Read a list of finite numbers.
/// @param values  allocated, to be freed; NULL on failure
/// @param n       their count
/// @return        false when it is no such list, or there is no memory
bool sim_json_numbers(const cJSON *list, double **values, size_t *n);

/// Read a list of two or more rising finite numbers.
/// @param n_pieces  one less than the numbers
bool sim_json_breaks(const cJSON *list, double **breaks, size_t *n_pieces);

/// Read parent.name as a piecewise cubic.
/// @param p      zero-initialised; to be freed in any case
/// @param where  dotted path of the parent, for messages
bool sim_json_cubics(sim_cubics_t *p, const cJSON *parent, const char *where, const char *name,
                     const char *path, common_error_t *e);

#endif
