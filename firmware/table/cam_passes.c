// SPDX-License-Identifier: Apache-2.0
#include "cam_passes.h"
#include "cam_fix.h" // cam_is_between
#include <stdbool.h> // bool
#include <stddef.h>  // NULL

_Static_assert(sizeof(cam_pass_t) == 16, "four words of the image");

cam_err_t cam_passes_check(const cam_entry_t *e, const cam_entry_place_t *in, uint64_t *used,
                           cam_table_t *table)
{
    if (table->passes != NULL || !cam_entry_is_plain(e, in) ||
        !cam_is_between(e->n_slices, 1, cam_table_max_passes)) {
        return cam_err_image_channel;
    }
    const cam_err_t err =
        cam_entry_check_layout(e, (uint64_t)e->n_slices * sizeof(cam_pass_t), in, used);
    if (err != cam_ok) {
        return err;
    }
    table->passes = (const cam_pass_t *)(const void *)(in->image + e->offset);
    table->n_passes = e->n_slices;
    // Feed and speed have the ranges of the header's; the stock falls from pass to pass, to 0.
    int64_t before_nm = cam_passes_most_nm + 1;
    bool is_good = true;
    for (uint32_t i = 0; i < e->n_slices; i++) {
        const cam_pass_t *pass = &table->passes[i];
        is_good = is_good && cam_is_between(pass->allowance_nm, 0, before_nm - 1) &&
                  cam_is_between(pass->feed_nm, 1, cam_table_max_feed_nm) &&
                  cam_is_between(pass->spindle_mrpm, 1, cam_table_max_mrpm) && pass->reserved == 0u;
        before_nm = pass->allowance_nm;
    }
    return is_good && before_nm == 0 ? cam_ok : cam_err_image_channel;
}
