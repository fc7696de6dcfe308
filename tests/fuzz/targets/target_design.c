// SPDX-License-Identifier: Apache-2.0
// The report of a table, which the gauge of the simulator takes the drawing from, is JSON of any
// content. What is read gives a number at every place.
#include "cam_table.h"
#include "fixture_image.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_file.h"
#include "fuzz_rig.h"
#include "sim_design.h"
#include <math.h>

enum { most_bytes = 4096 };

static cam_table_t table;

/// Every report is of this table: "@" stands for its CRC-32.
static size_t put_crc(uint8_t *text, const uint8_t *data, size_t size)
{
    size_t n = 0;
    for (size_t i = 0; i < size && n + 12u < (size_t)most_bytes; i++) {
        if (data[i] == '@') {
            n += (size_t)snprintf((char *)text + n, 12, "%lu", (unsigned long)table.crc32);
        } else {
            text[n++] = data[i];
        }
    }
    return n;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static uint8_t text[most_bytes];
    static common_error_t error;
    if (table.image == NULL) {
        size_t n;
        const void *image = fuzz_rig_image(0, &n);
        FUZZ_EXPECT(cam_table_check(image, n, &table) == cam_ok, "the table");
    }
    const size_t n = put_crc(text, data, size);
    const char *path = fuzz_file(text, n);
    sim_design_t design;
    bool is_there = false;
    error.text[0] = '\0';
    const bool is_good = sim_design_load(&design, path, &table, &error);
    fuzz_note(is_good);
    if (is_good) {
        for (int i = -1; i <= 5; i++) {
            const double r_mm = sim_design_radius_mm(&design, 0.2 * i, 0.3 * i);
            const double a_mm = sim_design_long_mm(&design, 0.3 * i);
            FUZZ_EXPECT(!isnan(a_mm) || isnan(r_mm), "no long axis at %g mm", 0.3 * i);
        }
        sim_design_free(&design);
    } else {
        FUZZ_EXPECT(error.text[0] != '\0', "refused without a word");
    }
    if (sim_design_load_target(&design, &is_there, path, &table, &error) && is_there) {
        sim_design_free(&design);
    }
    return 0;
}
