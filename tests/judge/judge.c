// SPDX-License-Identifier: Apache-2.0
// Judges cuts as the controller does: a line "IMAGE MACHINE MRPM" each, with the parameters that
// follow from a machine file, answered by a line of error, needed, limit, highest speed and feed.
#include "cam_feasible.h"
#include "sim_config.h"
#include "sim_file.h"
#include <inttypes.h>
#include <stdio.h>

enum { max_image_bytes = 1 << 22, max_path = 1000 };

/// @return whether the line could be judged
static bool judge(const char *image_path, const char *machine_path, uint32_t mrpm,
                  common_error_t *e)
{
    sim_config_t config = sim_config_defaults();
    sim_file_t file;
    if (!sim_config_load(&config, machine_path, e) ||
        !sim_file_read(&file, image_path, max_image_bytes, e)) {
        return false;
    }
    cam_table_t table;
    cam_params_t params;
    const cam_err_t err = cam_table_check(file.bytes, file.size, &table);
    const bool is_read = err == cam_ok && sim_controller_params(&params, &config.lathe, false,
                                                                &config.controller, e);
    if (err != cam_ok) {
        (void)common_error(e, "%s: %s", image_path, cam_err_text(err));
    } else if (is_read) {
        const cam_feasibility_t f =
            cam_feasible(&table, &params, mrpm, (uint32_t)config.lathe.tick_hz);
        (void)printf("%d %" PRId64 " %" PRId64 " %" PRIu32 " %" PRIu32 "\n", (int)f.err, f.needed,
                     f.limit, f.highest_mrpm, f.largest_feed_nm);
    }
    sim_file_free(&file);
    return is_read;
}

int main(void)
{
    char image[max_path + 1], machine[max_path + 1];
    uint32_t mrpm;
    while (scanf("%1000s %1000s %" SCNu32, image, machine, &mrpm) == 3) {
        common_error_t e = {0};
        if (!judge(image, machine, mrpm, &e)) {
            (void)fprintf(stderr, "judge: %s\n", e.text);
            return 2;
        }
    }
    return 0;
}
