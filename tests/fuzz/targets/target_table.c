// SPDX-License-Identifier: Apache-2.0
// A table image is untrusted bytes. What the check accepts is evaluated everywhere, and what it
// promises holds: no value leaves the bounds of TABLE_FORMAT.md.
#include "cam_eval.h"
#include "cam_fix.h"
#include "cam_table.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_image.h"
#include "fuzz_mutate.h"
#include <string.h>

enum { most_bytes = 8192, n_angles = 24, n_heights = 5 };

/// A table lies in memory aligned to 32 bytes. Images end at the end of it, so that a sanitizer
/// sees what reads beyond them.
static _Alignas(32) uint8_t places[most_bytes];

static int64_t unit_of(const cam_channel_t *ch, int32_t y)
{
    return ch->value_offset + (int64_t)y / (INT64_C(1) << ch->frac_bits);
}

/// Z stays between its first and its last height, but for the rounding of knots.
static void evaluate_way(const cam_table_t *t, int32_t z_nm)
{
    const cam_value_t w = cam_eval_profile(&t->way, z_nm);
    FUZZ_EXPECT(w.y <= CAM_TABLE_SUM_MAX && w.y >= -CAM_TABLE_SUM_MAX, "way %d", (int)w.y);
    const int64_t z = cam_feed_profile_at(t, z_nm).z_nm;
    const bool is_far =
        z < (int64_t)t->z_first_nm - 1002 || z > (int64_t)cam_feed_profile_z_last_nm(t) + 1002;
    FUZZ_EXPECT(!is_far || z_nm < t->z_first_nm || z_nm > t->z_last_nm, "Z %lld", (long long)z);
}

static void evaluate(const cam_table_t *t, uint32_t theta_q32, int32_t z_nm)
{
    const cam_value_t u = cam_eval_surface_at(&t->u, theta_q32, cam_eval_height(&t->u, z_nm));
    fuzz_note_words(&u, sizeof u);
    FUZZ_EXPECT(u.y <= CAM_TABLE_SUM_MAX && u.y >= -CAM_TABLE_SUM_MAX, "u %d", (int)u.y);
    const int64_t one = INT64_C(1) << t->u.frac_bits;
    FUZZ_EXPECT(u.y >= (t->u_min_nm - (int64_t)t->u.value_offset) * one &&
                    u.y <= (t->u_max_nm - (int64_t)t->u.value_offset) * one,
                "u %d beyond the promise", (int)u.y);
    if (t->speed.knots != NULL) {
        const cam_value_t r =
            cam_eval_surface_at(&t->speed, theta_q32, cam_eval_height(&t->speed, z_nm));
        const int64_t ratio = unit_of(&t->speed, r.y);
        FUZZ_EXPECT(ratio <= (int64_t)t->ratio_max_q20, "speed ratio %lld of %u", (long long)ratio,
                    (unsigned)t->ratio_max_q20);
    }
    if (t->angle.knots != NULL) {
        const cam_value_t a =
            cam_eval_surface_at(&t->angle, theta_q32, cam_eval_height(&t->angle, z_nm));
        const int64_t angle = unit_of(&t->angle, a.y);
        FUZZ_EXPECT(angle <= CAM_TABLE_ANGLE_MAX && angle >= -CAM_TABLE_ANGLE_MAX, "angle %lld",
                    (long long)angle);
    }
    const cam_value_t x = cam_eval_profile(&t->x, z_nm);
    FUZZ_EXPECT(x.y <= CAM_TABLE_SUM_MAX && x.y >= -CAM_TABLE_SUM_MAX, "x %d", (int)x.y);
    fuzz_note_words(&x, sizeof x);
    const int64_t x_nm = unit_of(&t->x, x.y);
    FUZZ_EXPECT(x_nm >= t->x_min_nm && x_nm <= t->x_max_nm, "x %lld", (long long)x_nm);
    if (t->way.knots != NULL) {
        evaluate_way(t, z_nm);
    }
}

static void judge(const cam_table_t *t)
{
    const size_t first = offsetof(cam_table_t, z_first_nm);
    const size_t end = offsetof(cam_table_t, crc32) + sizeof t->crc32;
    fuzz_note_words((const char *)t + first, end - first);
    fuzz_note_words(&t->swing, sizeof t->swing);
    fuzz_note_words(&t->u_change, sizeof t->u_change);
    fuzz_note_words(&t->swing_change, sizeof t->swing_change);
    FUZZ_EXPECT(t->image_size <= (uint32_t)most_bytes, "%u bytes", (unsigned)t->image_size);
    FUZZ_EXPECT(memchr(t->name, 0, sizeof t->name) != NULL, "name without an end");
    FUZZ_EXPECT(t->direction == 1 || t->direction == -1, "direction %d", (int)t->direction);
    FUZZ_EXPECT(t->z_first_nm < t->z_last_nm, "heights");
    FUZZ_EXPECT(t->u_min_nm <= t->u_max_nm, "bounds of u");
    FUZZ_EXPECT(t->n_lobes <= cam_table_max_lobes && t->n_passes <= cam_table_max_passes, "counts");
    const int64_t height_nm = (int64_t)t->z_last_nm - t->z_first_nm;
    for (uint32_t i = 0; i < (uint32_t)n_heights; i++) {
        const int64_t z_nm = t->z_first_nm + height_nm * ((int64_t)i * 2 - 1) / (n_heights + 1);
        for (uint32_t k = 0; k < (uint32_t)n_angles; k++) {
            evaluate(t, k * 0x0A80F00Du, cam_sat_i32(z_nm)); // no multiple of a knot's angle
        }
    }
    evaluate(t, 0xFFFFFFFFu, INT32_MAX);
    evaluate(t, 0, INT32_MIN);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size > (size_t)most_bytes) {
        return -1;
    }
    cam_table_t table;
    uint8_t *const image = places + (sizeof places - size) / 32u * 32u; // near its end
    memcpy(image, data, size);
    const cam_err_t err = cam_table_check(image, size, &table);
    fuzz_note(err);
    if (err == cam_ok) {
        judge(&table);
        return 0;
    }
    FUZZ_EXPECT(err < 0, "error %d", (int)err);
    FUZZ_EXPECT(table.u.knots == NULL && table.image == NULL, "a refused table is described");
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_image_mutate(data, size, max_size, seed, 0);
}
