// SPDX-License-Identifier: Apache-2.0
#include "sim_band.h"
#include "unity.h"
#include <string.h> // strstr

static sim_bands_t bands;
static common_error_t error;

static bool read_text(const char *text)
{
    cJSON *design = cJSON_Parse(text);
    bands = (sim_bands_t){0};
    const bool is_good = sim_bands_read(&bands, design, "part.json", &error);
    cJSON_Delete(design);
    return is_good;
}

#define TWO                                                                                        \
    "{\"bands\": [{\"low_mm\": 0, \"high_mm\": 4, \"run_mm\": 1, \"allowance_mm\": [0.1, 0], "     \
    "\"feed_mm\": [0.2, 0.1]}, "                                                                   \
    "{\"low_mm\": 6, \"high_mm\": 8, \"run_mm\": 0.5, \"allowance_mm\": [0], "                     \
    "\"feed_mm\": [0.3]}]}"

void setUp(void)
{
    TEST_ASSERT_TRUE(read_text(TWO));
}

/// Twice through the first band and back, then through the second one. Jitter at an edge does not
/// begin a pass anew; a tool that comes from above is in none.
static void test_passes_begin_below_a_band(void)
{
    static const struct {
        double z_mm;
        int band, n_begun; ///< -1: none
        bool is_last;
        double stock_mm;
    } steps[] = {{-1.0, -1, 0, false, 0.0}, {0.0, 0, 1, false, -1.0}, {-0.1, -1, 0, false, 0.0},
                 {0.1, 0, 1, false, -1.0},  {4.0, 0, 1, false, -1.0}, {4.1, -1, 0, false, 0.0},
                 {3.9, 0, 1, false, 0.1},   {1.0, 0, 1, false, 0.1},  {-0.6, -1, 0, false, 0.0},
                 {0.2, 0, 2, true, 0.1},    {3.9, 0, 2, true, 0.1},   {5.5, -1, 0, false, 0.0},
                 {2.0, 0, 2, false, 0.0},   {5.6, -1, 0, false, 0.0}, {6.1, 1, 1, true, -1.0},
                 {8.2, -1, 0, false, 0.0},  {7.0, 1, 1, false, 0.0}};
    for (uint32_t i = 0; i < sizeof steps / sizeof steps[0]; i++) {
        TEST_ASSERT_EQUAL(steps[i].z_mm > 6.2, sim_bands_are_done(&bands));
        const sim_band_t *band = sim_bands_follow(&bands, steps[i].z_mm);
        TEST_ASSERT_EQUAL_INT(steps[i].band, band == NULL ? -1 : (int)(band - bands.band));
        if (band != NULL) {
            TEST_ASSERT_EQUAL_INT(steps[i].n_begun, band->n_begun);
            TEST_ASSERT_EQUAL(steps[i].is_last, sim_band_is_last(band));
            TEST_ASSERT_EQUAL_DOUBLE(steps[i].stock_mm, sim_band_stock_mm(band));
        }
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.3, sim_bands_feed_mm(&bands));
    sim_bands_restart(&bands);
    TEST_ASSERT_EQUAL_PTR(&bands.band[1], sim_bands_follow(&bands, 7.0));
    TEST_ASSERT_EQUAL_INT(0, bands.band[1].n_begun);
}

static void test_malformed_bands_are_refused(void)
{
    static const char *const texts[] = {"{\"bands\": 3}",
                                        "{\"bands\": [{\"low_mm\": 4, \"high_mm\": 4, \"run_mm\": "
                                        "1, \"allowance_mm\": [0], \"feed_mm\": [1]}]}",
                                        "{\"bands\": [{\"low_mm\": 0, \"high_mm\": 4, \"run_mm\": "
                                        "0, \"allowance_mm\": [0], \"feed_mm\": [1]}]}",
                                        "{\"bands\": [{\"low_mm\": 0, \"high_mm\": 4, \"run_mm\": "
                                        "1, \"allowance_mm\": [], \"feed_mm\": []}]}",
                                        "{\"bands\": [{\"low_mm\": 0, \"high_mm\": 4, \"run_mm\": "
                                        "1, \"allowance_mm\": [0], \"feed_mm\": []}]}"};
    for (uint32_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        TEST_ASSERT_FALSE(read_text(texts[i]));
        TEST_ASSERT_NOT_NULL(strstr(error.text, "design.bands"));
    }
    TEST_ASSERT_TRUE(read_text("{}"));
    TEST_ASSERT_EQUAL_INT(0, bands.n);
}
