// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_table.h"
#include "cam/cam_barrel.h"  // cam_barrel_measure
#include "cam/cam_fix.h"     // cam_abs_i64
#include "cam/cam_peaks.h"   // cam_peaks_of_swing
#include "cam/cam_promise.h" // cam_promise_check
#include <stdbool.h>         // bool
#include <string.h>          // memcpy, memcmp

_Static_assert(sizeof(cam_knot_t) == 12, "a knot is three words of the image");

/// Offsets of TABLE_FORMAT.md.
enum {
    at_order = 8,
    at_version = 12,
    at_image_size = 16,
    at_crc = 20,
    at_header_size = 24,
    at_n_channels = 28,
    at_name = 32,
    at_z_first = 64,
    crc_from = 24,
    data_align = 32,
};

enum { kind_u = 1, kind_x = 2, kind_speed = 3, kind_swing = 4, kind_contact = 5 };

/// Header fields from at_z_first on, in the order of the image.
typedef struct {
    int32_t z_first_nm, z_last_nm, direction;
    uint32_t spindle_mrpm, feed_nm, depth_nm;
    uint32_t limit_u_stroke_nm, limit_u_speed_um_s, limit_u_acceleration_mm_s2, limit_spindle_mrpm;
    int32_t u_min_nm, u_max_nm;
    uint32_t u1_peak_nm_per_rad, u2_peak_nm_per_rad2, error_pm, spindle_peak_ppm;
} header_fields_t;
_Static_assert(at_z_first + sizeof(header_fields_t) == cam_table_header_size, "as in the format");

/// A channel entry, in the order of the image.
typedef struct {
    uint32_t kind, offset, size, n_slices, log2_knots, log2_repeat, frac_bits;
    int32_t z_first_nm, z_last_nm;
    uint32_t slices_per_nm_q48;
    int32_t offset_nm, p_min, p_max;
    uint32_t v_max, a_max, path;
} entry_t;
_Static_assert(sizeof(entry_t) == cam_table_entry_size, "as in the format");

/// Limits of the header that the ISR's arithmetic relies on.
enum {
    max_u_nm = 1 << 24,              // U set-points in nm / 64 fit int32 with amplitude 1.25
    max_u_offset_nm = (1 << 23) - 1, // in nm / 2^8 it fits int32
    max_frac_bits = 8,               // of 2^-8 nm: finer helps nobody, and every shift has room
    max_mrpm = 60000000,             // parameter range of the spindle speed
    max_feed_nm = 10000000,          // parameter range of the feed
    max_stroke_nm = 2 * max_u_nm,    //
    max_height_nm = 2000000000,      // heights and their differences fit int32
    max_spindle_ppm = 10000000,      // 10 / rad: |r dr/dturn| stays below 64
    min_ratio = CAM_TABLE_RATIO_ONE / 16,
    max_ratio = CAM_TABLE_RATIO_ONE * 4,
};

uint32_t cam_crc32(uint32_t crc, const void *data, size_t n)
{
    // One nibble per step: 64 bytes of table, fast enough for the slow side.
    static const uint32_t nibble[16] = {
        0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u,
        0x4DB26158u, 0x5005713Cu, 0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu,
        0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu,
    };
    const uint8_t *bytes = data;
    uint32_t rest = ~crc;
    for (size_t i = 0; i < n; i++) {
        rest ^= bytes[i];
        rest = (rest >> 4) ^ nibble[rest & 15u];
        rest = (rest >> 4) ^ nibble[rest & 15u];
    }
    return ~rest;
}

static uint32_t word_at(const uint8_t *image, size_t at)
{
    uint32_t word = 0;
    (void)memcpy(&word, image + at, sizeof word);
    return word;
}

static cam_err_t check_frame(const uint8_t *image, size_t size)
{
    static const uint8_t magic[8] = {0x43, 0x41, 0x4D, 0x54, 0x41, 0x42, 0x1A, 0x0A};
    if (size < cam_table_header_size) {
        return cam_err_image_size;
    }
    if (memcmp(image, magic, sizeof magic) != 0) {
        return cam_err_image_magic;
    }
    if (word_at(image, at_order) != 0x01020304u) {
        return cam_err_image_order;
    }
    if (word_at(image, at_version) != 1u) { // major 1, minor 0
        return cam_err_image_version;
    }
    if (word_at(image, at_image_size) != size || size % data_align != 0u) {
        return cam_err_image_size;
    }
    return cam_crc32(0, image + crc_from, size - crc_from) == word_at(image, at_crc)
               ? cam_ok
               : cam_err_image_crc;
}

static cam_err_t check_name(const uint8_t *name)
{
    size_t n = 0;
    while (n < cam_table_name_size && name[n] >= 0x20u && name[n] <= 0x7Eu) {
        n++;
    }
    bool is_padded = n > 0u && n < cam_table_name_size;
    for (size_t i = n; i < cam_table_name_size; i++) {
        is_padded = is_padded && name[i] == 0u;
    }
    return is_padded ? cam_ok : cam_err_image_name;
}

static bool is_within(int64_t value, int64_t low, int64_t high)
{
    return value >= low && value <= high;
}

static cam_err_t check_header(const uint8_t *image, header_fields_t *h)
{
    (void)memcpy(h, image + at_z_first, sizeof *h);
    const uint32_t n_channels = word_at(image, at_n_channels);
    const bool is_sound =
        word_at(image, at_header_size) == cam_table_header_size &&
        is_within(n_channels, 1, cam_table_max_channels) &&
        is_within(h->z_first_nm, -max_height_nm / 2, max_height_nm / 2) &&
        is_within(h->z_last_nm, (int64_t)h->z_first_nm + 1, max_height_nm / 2) &&
        (h->direction == 1 || h->direction == -1) && is_within(h->spindle_mrpm, 1, max_mrpm) &&
        is_within(h->feed_nm, 1, max_feed_nm) && is_within(h->depth_nm, 0, INT32_MAX) &&
        is_within(h->limit_u_stroke_nm, 1, max_stroke_nm) &&
        is_within(h->limit_u_speed_um_s, 1, INT32_MAX) &&
        is_within(h->limit_u_acceleration_mm_s2, 1, INT32_MAX) &&
        is_within(h->limit_spindle_mrpm, 1, max_mrpm) &&
        is_within(h->u_min_nm, -max_u_nm, max_u_nm) &&
        is_within(h->u_max_nm, h->u_min_nm, max_u_nm) &&
        is_within(h->u1_peak_nm_per_rad, 0, INT32_MAX) &&
        is_within(h->u2_peak_nm_per_rad2, 0, INT32_MAX) &&
        is_within(h->spindle_peak_ppm, 0, max_spindle_ppm);
    return is_sound ? check_name(image + at_name) : cam_err_image_header;
}

/// Do the bounds of a channel stay within a range of its unit? frac_bits is at most 8.
static bool is_inside(const entry_t *e, int64_t low, int64_t high)
{
    const int64_t one = INT64_C(1) << e->frac_bits;
    return is_within(e->offset_nm * one + e->p_min, low * one, high * one) &&
           is_within(e->offset_nm * one + e->p_max, low * one, high * one);
}

/// Speeds stay within a sixteenth and four times the mean, angles within a quarter turn.
static bool is_in_unit(const entry_t *e)
{
    if (e->kind == kind_speed) {
        return is_inside(e, min_ratio, max_ratio);
    }
    return e->kind < kind_swing || is_inside(e, -CAM_TABLE_ANGLE_MAX, CAM_TABLE_ANGLE_MAX);
}

static cam_err_t check_shape(const entry_t *e)
{
    const bool is_u = e->kind == kind_u;
    const bool is_turned = e->kind != kind_x;
    const bool is_sound = is_within(e->kind, kind_u, kind_contact) &&
                          is_within(e->n_slices, 2, cam_table_max_slices) &&
                          is_within(e->log2_knots, is_turned ? 2 : 0, is_turned ? 12 : 0) &&
                          is_within(e->log2_repeat, 0, is_turned ? 4 : 0) &&
                          e->frac_bits <= max_frac_bits && e->path <= (is_turned ? 0u : 1u) &&
                          is_within(e->p_min, -CAM_TABLE_SUM_MAX, e->p_max) &&
                          e->p_max <= CAM_TABLE_SUM_MAX && e->v_max <= CAM_TABLE_SUM_MAX &&
                          e->a_max <= CAM_TABLE_SUM_MAX &&
                          (!is_u || is_within(e->offset_nm, -max_u_offset_nm, max_u_offset_nm)) &&
                          is_within(e->offset_nm, -max_height_nm, max_height_nm) && is_in_unit(e);
    return is_sound ? cam_ok : cam_err_image_channel;
}

/// @param used  end of what lies before, moved behind this channel
static cam_err_t check_layout(const entry_t *e, uint32_t image_size, uint64_t *used)
{
    const uint64_t bytes = ((uint64_t)e->n_slices << e->log2_knots) * sizeof(cam_knot_t);
    const bool is_sound = e->offset % data_align == 0u && e->offset >= *used && e->size == bytes &&
                          e->offset + bytes <= image_size;
    *used = e->offset + bytes;
    return is_sound ? cam_ok : cam_err_image_layout;
}

static cam_err_t check_heights(const entry_t *e, const header_fields_t *h)
{
    const int64_t span_nm = (int64_t)e->z_last_nm - e->z_first_nm;
    const bool is_sound = is_within(e->z_first_nm, -max_height_nm / 2, h->z_first_nm) &&
                          is_within(e->z_last_nm, h->z_last_nm, max_height_nm / 2);
    if (!is_sound) {
        return cam_err_image_height;
    }
    const uint64_t n = e->n_slices - 1u;
    const bool is_spaced = (uint64_t)span_nm >= n * 65537u && (uint64_t)span_nm <= n * 16777216u;
    const uint64_t per_nm_q48 = ((n << 48) + (uint64_t)span_nm / 2u) / (uint64_t)span_nm;
    return is_spaced && per_nm_q48 == e->slices_per_nm_q48 ? cam_ok : cam_err_image_height;
}

static bool is_bounded(int64_t sum)
{
    return sum <= CAM_TABLE_SUM_MAX;
}

/// The three sums of TABLE_FORMAT.md, in 64 bits. Knots alone are bounded first.
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
    return is_bounded(p + v + a + c3 + c4 + c5) &&
           is_bounded(v + 2 * a + 3 * c3 + 4 * c4 + 5 * c5) &&
           is_bounded(2 * a + 6 * c3 + 12 * c4 + 20 * c5);
}

static cam_err_t check_knot(const entry_t *e, const cam_knot_t *k)
{
    const int64_t v = cam_abs_i64(k->v);
    const int64_t a = cam_abs_i64(k->a);
    const bool is_bounded_knot = is_bounded(cam_abs_i64(k->p)) && is_bounded(v) && is_bounded(a);
    const bool is_in_limits =
        is_within(k->p, e->p_min, e->p_max) && v <= (int64_t)e->v_max && a <= (int64_t)e->a_max;
    return !is_bounded_knot ? cam_err_image_knots : is_in_limits ? cam_ok : cam_err_image_limits;
}

/// All but x: every knot with its neighbour of the same slice, cyclic; x: every knot with the
/// next height.
static cam_err_t check_knots(const entry_t *e, const cam_knot_t *knots)
{
    const uint32_t n_in_slice = UINT32_C(1) << e->log2_knots;
    const uint32_t n = e->n_slices << e->log2_knots;
    for (uint32_t i = 0; i < n; i++) {
        const cam_err_t err = check_knot(e, &knots[i]);
        if (err != cam_ok) {
            return err;
        }
        const uint32_t in_slice = i & (n_in_slice - 1u);
        const uint32_t next = e->kind == kind_x
                                  ? (i + 1u < n ? i + 1u : i)
                                  : i - in_slice + ((in_slice + 1u) & (n_in_slice - 1u));
        const bool has_next = e->kind != kind_x || i + 1u < n;
        if (has_next && !is_segment_safe(&knots[i], &knots[next])) {
            return cam_err_image_knots;
        }
    }
    return cam_ok;
}

/// @return at most: a derivative per knot interval as one per rad; |x| < 2^41; 2^24 / 2 pi rounded
/// down
static int64_t knot_per_rad(int64_t x, uint32_t turn_shift)
{
    return (x * 2670176) >> 24 << turn_shift;
}

/// The stroke that the header promises must cover the bounds of u's knots.
static cam_err_t check_stroke(const entry_t *e, const header_fields_t *h)
{
    const int64_t low_nm = e->offset_nm + (e->p_min >> e->frac_bits);
    const int64_t high_nm = e->offset_nm + (e->p_max >> e->frac_bits);
    return low_nm >= h->u_min_nm && high_nm <= h->u_max_nm ? cam_ok : cam_err_image_limits;
}

/// At uniform speed the peaks that the header promises must cover the bounds of u's knots.
static cam_err_t check_peaks(const entry_t *e, const header_fields_t *h)
{
    const uint32_t turn_shift = e->log2_knots + e->log2_repeat;
    const int64_t u1 = knot_per_rad(e->v_max, turn_shift) >> e->frac_bits;
    const int64_t u2 =
        knot_per_rad(knot_per_rad(INT64_C(2) * e->a_max, turn_shift), turn_shift) >> e->frac_bits;
    const bool is_covered = u1 <= (int64_t)h->u1_peak_nm_per_rad &&
                            u2 <= (int64_t)h->u2_peak_nm_per_rad2 && h->spindle_peak_ppm == 0u;
    return is_covered ? cam_ok : cam_err_image_limits;
}

static void describe(const entry_t *e, const uint8_t *image, cam_channel_t *ch)
{
    *ch = (cam_channel_t){
        .knots = (const cam_knot_t *)(const void *)(image + e->offset),
        .n_slices = e->n_slices,
        .log2_knots = e->log2_knots,
        .log2_repeat = e->log2_repeat,
        .frac_bits = e->frac_bits,
        .z_first_nm = e->z_first_nm,
        .span_nm = (uint32_t)((int64_t)e->z_last_nm - e->z_first_nm),
        .slices_per_nm_q48 = e->slices_per_nm_q48,
        .offset_nm = e->offset_nm,
    };
}

static cam_err_t check_entry(const entry_t *e, const header_fields_t *h, const uint8_t *image,
                             uint64_t *used)
{
    cam_err_t err = check_shape(e);
    if (err == cam_ok) {
        err = check_layout(e, word_at(image, at_image_size), used);
    }
    if (err == cam_ok) {
        err = check_heights(e, h);
    }
    if (err == cam_ok) {
        err = check_knots(e, (const cam_knot_t *)(const void *)(image + e->offset));
    }
    return err == cam_ok && e->kind == kind_u ? check_stroke(e, h) : err;
}

static cam_channel_t *channel_of(cam_table_t *table, uint32_t kind)
{
    switch (kind) {
    case kind_u:
        return &table->u;
    case kind_x:
        return &table->x;
    case kind_speed:
        return &table->speed;
    default:
        return &table->angle;
    }
}

/// What the header promises of the motion, once all channels are known.
static cam_err_t check_promise(const entry_t *u, const header_fields_t *h, cam_table_t *table)
{
    table->u1_peak_nm_per_rad = h->u1_peak_nm_per_rad;
    table->u2_peak_nm_per_rad2 = h->u2_peak_nm_per_rad2;
    table->spindle_peak_ppm = h->spindle_peak_ppm;
    return table->speed.knots == NULL ? check_peaks(u, h) : cam_promise_check(table);
}

static cam_err_t check_channels(const uint8_t *image, const header_fields_t *h, cam_table_t *table)
{
    const uint32_t n = word_at(image, at_n_channels);
    uint64_t used = cam_table_header_size + (uint64_t)n * cam_table_entry_size;
    if (used > word_at(image, at_image_size)) {
        return cam_err_image_layout;
    }
    entry_t u = {0};
    table->ratio_max_q20 = CAM_TABLE_RATIO_ONE;
    for (uint32_t i = 0; i < n; i++) {
        entry_t e;
        (void)memcpy(&e, image + cam_table_header_size + (size_t)i * cam_table_entry_size,
                     sizeof e);
        const cam_err_t err = check_entry(&e, h, image, &used);
        if (err != cam_ok) {
            return err;
        }
        cam_channel_t *ch = channel_of(table, e.kind);
        if (ch->knots != NULL) {
            return cam_err_image_channel;
        }
        describe(&e, image, ch);
        u = e.kind == kind_u ? e : u;
        table->is_swung = table->is_swung || e.kind == kind_swing;
        table->is_ring_helix = table->is_ring_helix || e.path != 0u;
        if (e.kind == kind_speed) {
            table->ratio_max_q20 = (uint32_t)(e.offset_nm + (e.p_max >> e.frac_bits) + 2);
        }
    }
    const bool is_steady = table->speed.knots == NULL || !table->is_ring_helix;
    const bool is_complete = table->u.knots != NULL && table->x.knots != NULL && is_steady;
    return is_complete ? check_promise(&u, h, table) : cam_err_image_channel;
}

static void fill(const uint8_t *image, const header_fields_t *h, cam_table_t *table)
{
    (void)memcpy(table->name, image + at_name, sizeof table->name);
    table->z_first_nm = h->z_first_nm;
    table->z_last_nm = h->z_last_nm;
    table->direction = h->direction;
    table->spindle_mrpm = h->spindle_mrpm;
    table->feed_nm = h->feed_nm;
    table->depth_nm = h->depth_nm;
    table->limit_u_stroke_nm = h->limit_u_stroke_nm;
    table->limit_u_speed_um_s = h->limit_u_speed_um_s;
    table->limit_u_acceleration_mm_s2 = h->limit_u_acceleration_mm_s2;
    table->limit_spindle_mrpm = h->limit_spindle_mrpm;
    table->u_min_nm = h->u_min_nm;
    table->u_max_nm = h->u_max_nm;
    table->error_pm = h->error_pm;
    table->crc32 = word_at(image, at_crc);
    table->image = image;
    table->image_size = word_at(image, at_image_size);
}

/// What the format does not promise is measured.
static void measure(cam_table_t *table)
{
    cam_barrel_measure(table);
    table->u_change = cam_peaks_of_change(&table->u);
    if (table->is_swung) {
        table->swing = cam_peaks_of_swing(&table->angle);
        table->swing_change = cam_peaks_of_change(&table->angle);
    }
}

cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table)
{
    header_fields_t header;
    cam_table_t found = {0};
    *table = found;
    if (image == NULL || (uintptr_t)image % sizeof(uint32_t) != 0u) { // MISRA D18
        return cam_err_image_address;
    }
    cam_err_t err = check_frame(image, size);
    if (err == cam_ok) {
        err = check_header(image, &header);
    }
    if (err == cam_ok) {
        err = check_channels(image, &header, &found);
    }
    if (err != cam_ok) {
        return err;
    }
    fill(image, &header, &found);
    measure(&found);
    *table = found;
    return cam_ok;
}
