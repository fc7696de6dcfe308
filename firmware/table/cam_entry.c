// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_fix.h" // cam_is_between

/// Limits that the arithmetic of the evaluation relies on.
enum {
    max_u_offset_nm = (1 << 23) - 1, // fits int32 in units of 2^-8 nm
    max_frac_bits = 8,               // 2^-8 nm is finer than any axis; no shift overflows
    min_ratio = CAM_TABLE_RATIO_ONE / 16,
    max_ratio = CAM_TABLE_RATIO_ONE * 4,
    max_allowance_nm = 10000000,
};
_Static_assert(sizeof(cam_pass_t) == 16, "four words of the image");

bool cam_entry_is_over_angle(const cam_entry_t *e)
{
    return e->kind != (uint32_t)cam_kind_x && e->kind != (uint32_t)cam_kind_way;
}

bool cam_entry_is_in_unit(const cam_entry_t *e, cam_extent_t values)
{
    if (e->kind == (uint32_t)cam_kind_speed) {
        return values.low >= min_ratio && values.high <= max_ratio;
    }
    const bool is_angle =
        e->kind == (uint32_t)cam_kind_swing || e->kind == (uint32_t)cam_kind_contact;
    return !is_angle || (values.low >= -CAM_TABLE_ANGLE_MAX && values.high <= CAM_TABLE_ANGLE_MAX);
}

/// @return [unit] the range from p_min to p_max, rounded outwards
static cam_extent_t knot_range(const cam_entry_t *e)
{
    const int64_t below_one = (INT64_C(1) << e->frac_bits) - 1;
    return (cam_extent_t){(int64_t)e->value_offset + (e->p_min >> e->frac_bits),
                          e->value_offset + ((e->p_max + below_one) >> e->frac_bits)};
}

static cam_err_t check_shape(const cam_entry_t *e)
{
    const bool is_u = e->kind == cam_kind_u;
    const bool is_around = cam_entry_is_over_angle(e);
    const bool is_known =
        cam_is_between(e->kind, cam_kind_u, cam_kind_contact) || e->kind == cam_kind_way;
    const bool is_sound =
        is_known && cam_is_between(e->n_slices, 2, cam_table_max_slices) &&
        cam_is_between(e->log2_knots, is_around ? 2 : 0, is_around ? 12 : 0) &&
        cam_is_between(e->log2_repeat, 0, is_around ? 4 : 0) && e->frac_bits <= max_frac_bits &&
        e->path <= (is_around ? 0u : 1u) &&
        cam_is_between(e->p_min, -CAM_TABLE_SUM_MAX, e->p_max) && e->p_max <= CAM_TABLE_SUM_MAX &&
        e->v_max <= CAM_TABLE_SUM_MAX && e->a_max <= CAM_TABLE_SUM_MAX &&
        (!is_u || cam_is_between(e->value_offset, -max_u_offset_nm, max_u_offset_nm)) &&
        cam_is_between(e->value_offset, -cam_entry_max_height_nm, cam_entry_max_height_nm) &&
        cam_entry_is_in_unit(e, knot_range(e));
    return is_sound ? cam_ok : cam_err_image_channel;
}

/// Check the offset and size of an entry's data.
/// @param bytes  expected size
static cam_err_t check_layout(const cam_entry_t *e, uint64_t bytes, const cam_table_t *t,
                              uint64_t *used)
{
    const bool is_sound = e->offset % cam_entry_align == 0u && e->offset >= *used &&
                          e->size == bytes && e->offset + bytes <= t->image_size;
    *used = e->offset + bytes;
    return is_sound ? cam_ok : cam_err_image_layout;
}

cam_err_t cam_entry_check_records(const cam_entry_t *e, uint32_t most, size_t size,
                                  const cam_table_t *t, uint64_t *used)
{
    const uint32_t unused = e->log2_knots | e->log2_repeat | e->frac_bits | e->slices_per_nm_q48 |
                            (uint32_t)e->value_offset | (uint32_t)e->p_min | (uint32_t)e->p_max |
                            e->v_max | e->a_max | e->path;
    const bool is_sound = unused == 0u && e->z_first_nm == t->z_first_nm &&
                          e->z_last_nm == t->z_last_nm && cam_is_between(e->n_slices, 1, most);
    return is_sound ? check_layout(e, (uint64_t)e->n_slices * size, t, used)
                    : cam_err_image_channel;
}

cam_err_t cam_entry_check_passes(const cam_entry_t *e, uint64_t *used, cam_table_t *t)
{
    if (t->passes != NULL) {
        return cam_err_image_channel;
    }
    const cam_err_t err =
        cam_entry_check_records(e, cam_table_max_passes, sizeof(cam_pass_t), t, used);
    if (err != cam_ok) {
        return err;
    }
    t->passes = cam_entry_data(e, t);
    t->n_passes = e->n_slices;
    // Feed and speed have the ranges of the header's; the stock falls from pass to pass, to 0.
    int64_t before_nm = max_allowance_nm + 1;
    bool is_good = true;
    for (uint32_t i = 0; i < t->n_passes; i++) {
        const cam_pass_t *pass = &t->passes[i];
        is_good = is_good && cam_is_between(pass->allowance_nm, 0, before_nm - 1) &&
                  cam_is_between(pass->feed_nm, 1, cam_table_max_feed_nm) &&
                  cam_is_between(pass->spindle_mrpm, 1, cam_table_max_mrpm) && pass->reserved == 0u;
        before_nm = pass->allowance_nm;
    }
    return is_good && before_nm == 0 ? cam_ok : cam_err_image_channel;
}

/// Check the range of heights, the spacing of the slices and its stored reciprocal. Patterns of
/// lobes are found by their number and have the heights of the whole table.
static cam_err_t check_heights(const cam_entry_t *e, const cam_table_t *t)
{
    if (t->lobes != NULL && cam_entry_is_over_angle(e)) {
        const bool is_pattern = e->z_first_nm == t->z_first_nm && e->z_last_nm == t->z_last_nm &&
                                e->slices_per_nm_q48 == 0u;
        return is_pattern ? cam_ok : cam_err_image_height;
    }
    if (!cam_is_between(e->z_first_nm, -cam_entry_max_height_nm / 2, t->z_first_nm) ||
        !cam_is_between(e->z_last_nm, t->z_last_nm, cam_entry_max_height_nm / 2)) {
        return cam_err_image_height;
    }
    const int64_t span_nm = (int64_t)e->z_last_nm - e->z_first_nm;
    const uint64_t n = e->n_slices - 1u;
    const bool is_spaced = (uint64_t)span_nm >= n * 65537u && (uint64_t)span_nm <= n * 16777216u;
    const uint64_t per_nm_q48 = ((n << 48) + (uint64_t)span_nm / 2u) / (uint64_t)span_nm;
    return is_spaced && per_nm_q48 == e->slices_per_nm_q48 ? cam_ok : cam_err_image_height;
}

/// Check the three sums of TABLE_FORMAT.md ("The bound"), which fit 64 bits for bounded knots.
static bool is_segment_safe(const cam_knot_t *k0, const cam_knot_t *k1)
{
    const int64_t p = cam_abs_i64(k0->p);
    const int64_t v = cam_abs_i64(k0->v);
    const int64_t a = cam_abs_i64(k0->a);
    const int64_t dp = (int64_t)k1->p - k0->p - k0->v - k0->a;
    const int64_t dv = (int64_t)k1->v - k0->v - INT64_C(2) * k0->a;
    const int64_t da = (int64_t)k1->a - k0->a;
    const int64_t c3 = cam_abs_i64(10 * dp - 4 * dv + da);
    const int64_t c4 = cam_abs_i64(-15 * dp + 7 * dv - 2 * da);
    const int64_t c5 = cam_abs_i64(6 * dp - 3 * dv + da);
    return p + v + a + c3 + c4 + c5 <= CAM_TABLE_SUM_MAX &&
           v + 2 * a + 3 * c3 + 4 * c4 + 5 * c5 <= CAM_TABLE_SUM_MAX &&
           2 * a + 6 * c3 + 12 * c4 + 20 * c5 <= CAM_TABLE_SUM_MAX;
}

/// Check a knot against the bounds of the arithmetic, then against those of the entry.
static cam_err_t check_knot(const cam_entry_t *e, const cam_knot_t *k)
{
    const int64_t v = cam_abs_i64(k->v);
    const int64_t a = cam_abs_i64(k->a);
    if (cam_abs_i64(k->p) > CAM_TABLE_SUM_MAX || v > CAM_TABLE_SUM_MAX || a > CAM_TABLE_SUM_MAX) {
        return cam_err_image_knots;
    }
    const bool is_in_limits = cam_is_between(k->p, e->p_min, e->p_max) && v <= (int64_t)e->v_max &&
                              a <= (int64_t)e->a_max;
    return is_in_limits ? cam_ok : cam_err_image_limits;
}

/// Check every knot and the segment from it to the next one: over angle the next knot of the same
/// slice, cyclically; over height alone that of the next slice.
static cam_err_t check_knots(const cam_entry_t *e, const cam_channel_t *ch)
{
    const bool is_around = cam_entry_is_over_angle(e);
    const uint32_t n = e->n_slices << e->log2_knots;
    for (uint32_t i = 0; i < n; i++) {
        const cam_err_t err = check_knot(e, &ch->knots[i]);
        if (err != cam_ok) {
            return err;
        }
        const uint32_t next = is_around ? cam_bounds_next(ch, i) : i + 1u;
        if (next < n && !is_segment_safe(&ch->knots[i], &ch->knots[next])) {
            return cam_err_image_knots;
        }
    }
    return cam_ok;
}

cam_err_t cam_entry_check(const cam_entry_t *e, const cam_table_t *t, uint64_t *used)
{
    cam_err_t err = check_shape(e);
    if (err == cam_ok) {
        const uint64_t n_knots = (uint64_t)e->n_slices << e->log2_knots;
        err = check_layout(e, n_knots * sizeof(cam_knot_t), t, used);
    }
    err = err == cam_ok ? check_heights(e, t) : err;
    if (err != cam_ok) {
        return err;
    }
    const cam_channel_t ch = cam_entry_channel(e, t);
    return check_knots(e, &ch);
}

const void *cam_entry_data(const cam_entry_t *e, const cam_table_t *t)
{
    const uint8_t *image = t->image;
    return image + e->offset;
}

cam_channel_t cam_entry_channel(const cam_entry_t *e, const cam_table_t *t)
{
    return (cam_channel_t){
        .knots = cam_entry_data(e, t),
        .n_slices = e->n_slices,
        .log2_knots = e->log2_knots,
        .log2_repeat = e->log2_repeat,
        .frac_bits = e->frac_bits,
        .z_first_nm = e->z_first_nm,
        .span_nm = (uint32_t)((int64_t)e->z_last_nm - e->z_first_nm),
        .slices_per_nm_q48 = e->slices_per_nm_q48,
        .value_offset = e->value_offset,
    };
}
