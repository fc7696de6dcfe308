// SPDX-License-Identifier: Apache-2.0
#include "cam_err.h"
#include "unity.h"
#include <stdbool.h>
#include <stdint.h>
#include <string.h> // strcmp, strlen

#define ROW(name, unit, per_unit, param) {unit, #param, per_unit},
static const struct {
    const char *unit, *param;
    int32_t per_unit;
} rows[] = {CAM_ERR_LIMITS(ROW)};
enum { n_rows = sizeof rows / sizeof rows[0] };

/// Units for people, and what a parameter with such a limit ends in.
static const struct {
    const char *unit, *suffix;
    int32_t per_unit;
} units[] = {{"mm", "_nm", 1000000},
             {"mm/s", "_um_per_s", 1000},
             {"mm/s2", "_mm_per_s2", 1},
             {"r/min", "_mrpm", 1000},
             {"rad/s", "_mrad_per_s", 1000},
             {"rad/s2", "_mrad_per_s2", 1000},
             {"degrees", "_mdeg", 1000},
             {"degrees/s", "_mdeg_per_s", 1000},
             {"degrees/s2", "_deg_per_s2", 1},
             {"N", "_mn", 1000},
             {"N rms", "_mn", 1000},
             {"%", "_ppm", 10000},
             {"turns", "", 1},
             {"swing axis", "", 1}};
enum { n_units = sizeof units / sizeof units[0] };

static bool ends_in(const char *name, const char *suffix)
{
    const size_t n = strlen(name), k = strlen(suffix);
    return n >= k && strcmp(&name[n - k], suffix) == 0;
}

/// A limit in a wrong unit would send the operator to a wrong number.
static void test_refusals_have_the_unit_of_their_parameter(void)
{
    for (uint32_t i = 0; i < n_rows; i++) {
        uint32_t k = 0;
        while (k < n_units && strcmp(units[k].unit, rows[i].unit) != 0) {
            k++;
        }
        TEST_ASSERT_LESS_THAN_UINT32_MESSAGE(n_units, k, rows[i].unit);
        TEST_ASSERT_EQUAL_INT32_MESSAGE(units[k].per_unit, rows[i].per_unit, rows[i].unit);
        const bool has_param = strcmp(rows[i].param, "none") != 0;
        TEST_ASSERT_TRUE_MESSAGE(!has_param || ends_in(rows[i].param, units[k].suffix),
                                 rows[i].param);
    }
}
