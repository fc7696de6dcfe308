// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_eval.h" // cam_lobes_change_q31, cam_lobes_find
#include <stdbool.h>  // bool

_Static_assert(sizeof(cam_lobe_t) == 20, "five words of the image");
_Static_assert(cam_table_max_lobes == 1 << 6, "the search halves it down to one lobe");

enum { least_gap_nm = 200000 }; ///< [nm] between two lobes

/// @return [nm] height over which the lift falls above a lobe, and rises below the next one
static int64_t change_nm(const cam_lobe_t *lobe)
{
    return ((int64_t)lobe[1].z_first_nm - lobe->z_last_nm) / 2 - cam_lobes_kept_off_nm;
}

static bool is_gap_good(const cam_lobe_t *lobe)
{
    const int64_t nm = change_nm(lobe);
    return nm >= least_gap_nm / 2 - cam_lobes_kept_off_nm &&
           lobe->changes_per_nm_q48 == ((INT64_C(1) << 48) + nm / 2) / nm;
}

/// Check that the lobes rise from the first height of the table to its last, with gaps between.
static bool are_rising(const cam_lobe_t *lobe, const cam_entry_t *e)
{
    const uint32_t last = e->n_slices - 1u;
    bool is_good = lobe[0].z_first_nm == e->z_first_nm && lobe[last].z_last_nm == e->z_last_nm &&
                   lobe[last].changes_per_nm_q48 == 0u;
    for (uint32_t i = 0; i <= last; i++) {
        is_good = is_good && lobe[i].z_last_nm > lobe[i].z_first_nm &&
                  (i == last || is_gap_good(&lobe[i]));
    }
    return is_good;
}

cam_err_t cam_lobes_check(const cam_entry_t *e, uint64_t *used, cam_table_t *table)
{
    const cam_err_t err =
        cam_entry_check_records(e, cam_table_max_lobes, sizeof(cam_lobe_t), table, used);
    if (err != cam_ok) {
        return err;
    }
    const cam_lobe_t *lobe = cam_entry_data(e, table);
    if (!are_rising(lobe, e)) {
        return cam_err_image_height;
    }
    table->lobes = lobe;
    table->n_lobes = e->n_slices;
    for (uint32_t i = 0; i + 1u < table->n_lobes; i++) {
        const uint32_t nm = (uint32_t)change_nm(&lobe[i]);
        table->least_change_nm =
            i == 0u || nm < table->least_change_nm ? nm : table->least_change_nm;
    }
    return cam_ok;
}

cam_err_t cam_lobes_check_patterns(const cam_table_t *t)
{
    bool is_good = t->angle.knots != NULL && t->angle.n_slices == t->u.n_slices &&
                   (t->speed.knots == NULL || t->speed.n_slices == t->u.n_slices) &&
                   !t->is_ring_helix;
    for (uint32_t i = 0; i < t->n_lobes; i++) {
        is_good = is_good && t->lobes[i].pattern < t->u.n_slices;
    }
    return is_good ? cam_ok : cam_err_image_channel;
}

uint32_t cam_lobes_find(const cam_table_t *t, int32_t z_nm)
{
    uint32_t found = 0;
    for (uint32_t step = cam_table_max_lobes / 2; step > 0u; step >>= 1) {
        const uint32_t i = found + step;
        if (i < t->n_lobes) { // compare with the middle of the gap below lobe i
            const uint32_t below_nm = (uint32_t)t->lobes[i - 1u].z_last_nm;
            const uint32_t gap_nm = (uint32_t)t->lobes[i].z_first_nm - below_nm;
            found = z_nm >= (int32_t)(below_nm + gap_nm / 2u) ? i : found;
        }
    }
    return found;
}

int32_t cam_lobes_change_q31(const cam_table_t *t, uint32_t i, int32_t z_nm)
{
    const cam_lobe_t *lobe = &t->lobes[i];
    const bool is_below = z_nm < lobe->z_first_nm;
    if (!is_below && z_nm <= lobe->z_last_nm) {
        return 0;
    }
    const uint32_t off_nm = is_below ? (uint32_t)lobe->z_first_nm - (uint32_t)z_nm
                                     : (uint32_t)z_nm - (uint32_t)lobe->z_last_nm;
    //@ split is_below;
    if (off_nm <= (uint32_t)cam_lobes_kept_off_nm || (is_below && i == 0u)) {
        return 0;
    }
    const uint32_t per_nm_q48 =
        is_below ? t->lobes[i - 1u].changes_per_nm_q48 : lobe->changes_per_nm_q48;
    const uint64_t q31 = ((uint64_t)(off_nm - (uint32_t)cam_lobes_kept_off_nm) * per_nm_q48) >> 17;
    return q31 < (uint64_t)INT32_MAX ? (int32_t)q31 : INT32_MAX;
}
