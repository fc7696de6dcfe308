// SPDX-License-Identifier: Apache-2.0
#include "cam_table_inner.h"
#include "cam_fix.h" // cam_is_between
#include <stddef.h>  // offsetof
#include <string.h>  // memcpy, memcmp

_Static_assert(sizeof(cam_knot_t) == 12, "a knot is three words of the image");
_Static_assert(offsetof(cam_table_t, u3_peak_nm_per_rad3) - offsetof(cam_table_t, name) ==
                   cam_table_header_size - 32,
               "the members are those of the header");

/// Offsets of some of the header's fields in bytes: TABLE_FORMAT.md, "Header".
enum {
    at_order = 8,
    at_version = 12,
    at_image_size = 16,
    at_crc = 20,
    at_header_size = 24,
    at_n_channels = 28,
    at_name = 32,
    crc_from = 24,
};

/// Known versions; kinds from cam_kind_newer on make it the second.
enum { version_1_0 = 1, version_1_1 = 0x10001 };

/// Limits of header fields that the interrupt's arithmetic relies on.
enum {
    max_u_nm = 1 << 24,           // set-points of U in nm / 64 fit int32 at amplitude 1.25
    max_stroke_nm = 2 * max_u_nm, // from -max_u_nm to max_u_nm
    max_spindle_ppm = 10000000,   // 10 / rad, so that |r dr/dturn| stays below 64
};

uint32_t cam_crc32(uint32_t crc, const void *data, size_t n)
{
    // One nibble per step needs only a 64-byte table and is fast enough for the slow side.
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

/// @return the word at an offset in bytes; any alignment
static uint32_t word_at(const uint8_t *image, size_t at)
{
    uint32_t word = 0;
    (void)memcpy(&word, image + at, sizeof word);
    return word;
}

/// Check magic, byte order, version, size and CRC, before any other field is trusted.
static cam_err_t check_frame(const uint8_t *image, size_t offered)
{
    static const uint8_t magic[8] = {0x43, 0x41, 0x4D, 0x54, 0x41, 0x42, 0x1A, 0x0A};
    if (offered < cam_table_header_size) {
        return cam_err_image_size;
    }
    const size_t stored = word_at(image, at_image_size);
    if (memcmp(image, magic, sizeof magic) != 0) {
        return cam_err_image_magic;
    }
    if (word_at(image, at_order) != 0x01020304u) {
        return cam_err_image_order;
    }
    const uint32_t version = word_at(image, at_version); // major, and minor << 16
    if (version != version_1_0 && version != version_1_1) {
        return cam_err_image_version;
    }
    if (stored != offered || offered % cam_entry_align != 0u) {
        return cam_err_image_size;
    }
    return cam_crc32(0, image + crc_from, offered - crc_from) == word_at(image, at_crc)
               ? cam_ok
               : cam_err_image_crc;
}

/// Check that a name is one or more printable characters, padded with zeros.
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

static bool is_header_sound(const cam_table_t *t)
{
    const int32_t max_height_nm = cam_entry_max_height_nm / 2;
    return cam_is_between(word_at(t->image, at_n_channels), 1, cam_table_max_channels) &&
           cam_is_between(t->z_first_nm, -max_height_nm, max_height_nm) &&
           cam_is_between(t->z_last_nm, (int64_t)t->z_first_nm + 1, max_height_nm) &&
           (t->direction == 1 || t->direction == -1) &&
           cam_is_between(t->spindle_mrpm, 1, cam_table_max_mrpm) &&
           cam_is_between(t->feed_nm, 1, cam_table_max_feed_nm) &&
           cam_is_between(t->depth_nm, 0, INT32_MAX) &&
           cam_is_between(t->limit_u_stroke_nm, 1, max_stroke_nm) &&
           cam_is_between(t->limit_u_speed_um_per_s, 1, INT32_MAX) &&
           cam_is_between(t->limit_u_acceleration_mm_per_s2, 1, INT32_MAX) &&
           cam_is_between(t->limit_spindle_mrpm, 1, cam_table_max_mrpm) &&
           cam_is_between(t->u_min_nm, -max_u_nm, max_u_nm) &&
           cam_is_between(t->u_max_nm, t->u_min_nm, max_u_nm) &&
           cam_is_between(t->u1_peak_nm_per_rad, 0, INT32_MAX) &&
           cam_is_between(t->u2_peak_nm_per_rad2, 0, INT32_MAX) &&
           cam_is_between(t->spindle_peak_ppm_per_rad, 0, max_spindle_ppm);
}

static cam_err_t check_header(const uint8_t *image, cam_table_t *t)
{
    *t = (cam_table_t){
        .image = image,
        .image_size = word_at(image, at_image_size),
        .crc32 = word_at(image, at_crc),
    };
    (void)memcpy((uint8_t *)t + offsetof(cam_table_t, name), image + at_name,
                 cam_table_header_size - at_name);
    return word_at(image, at_header_size) == cam_table_header_size && is_header_sound(t)
               ? check_name(image + at_name)
               : cam_err_image_header;
}

/// Find the range of a channel's values, between the knots too, and check it: u against the
/// header's limits, which with lobes include 0 (the middle of a gap), other channels against the
/// limits of their kind. Nothing needs the range of a way between its knots.
static cam_err_t check_values(const cam_entry_t *e, const cam_table_t *t, cam_extent_t *values)
{
    const cam_channel_t ch = cam_entry_channel(e, t);
    const bool is_around = cam_entry_is_over_angle(e);
    if (e->kind == (uint32_t)cam_kind_u) {
        *values = cam_extent_widened(&ch, is_around, (cam_extent_t){t->u_min_nm, t->u_max_nm});
        const bool is_kept = values->low == t->u_min_nm && values->high == t->u_max_nm &&
                             (t->lobes == NULL || cam_is_between(0, values->low, values->high));
        return is_kept ? cam_ok : cam_err_image_limits;
    }
    *values = cam_extent_of_knots(&ch, e->p_min, e->p_max);
    if (e->kind != (uint32_t)cam_kind_way) {
        *values = cam_extent_widened(&ch, is_around, *values);
    }
    return cam_entry_is_in_unit(e, *values) ? cam_ok : cam_err_image_limits;
}

/// @return a derivative per knot interval, converted to per rad, rounded down
static int64_t knot_per_rad(int64_t x, uint32_t log2_knots_per_turn)
{
    return cam_per_rad(x) << log2_knots_per_turn;
}

/// Check the header's motion limits. At uniform speed they must cover the bounds of u's knots; with
/// a speed channel every knot is evaluated.
static cam_err_t check_motion_limits(const cam_entry_t *u, const cam_table_t *t)
{
    if (t->speed.knots != NULL) {
        return cam_peaks_check(t);
    }
    const uint32_t log2_knots = u->log2_knots + u->log2_repeat; // per turn
    const int64_t u1 = knot_per_rad(u->v_max, log2_knots) >> u->frac_bits;
    const int64_t u2 =
        knot_per_rad(knot_per_rad(INT64_C(2) * u->a_max, log2_knots), log2_knots) >> u->frac_bits;
    const bool is_covered = u1 <= (int64_t)t->u1_peak_nm_per_rad &&
                            u2 <= (int64_t)t->u2_peak_nm_per_rad2 &&
                            t->spindle_peak_ppm_per_rad == 0u;
    return is_covered ? cam_ok : cam_err_image_limits;
}

/// Put a checked channel into the table, which must not have one of this kind yet. Swing and
/// contact exclude each other and share one channel.
static cam_err_t take_channel(const cam_entry_t *e, cam_extent_t values, cam_table_t *table)
{
    cam_channel_t *const channels[cam_kind_way + 1] = {
        [cam_kind_u] = &table->u,           [cam_kind_x] = &table->x,
        [cam_kind_speed] = &table->speed,   [cam_kind_swing] = &table->angle,
        [cam_kind_contact] = &table->angle, [cam_kind_way] = &table->way,
    };
    cam_channel_t *ch = channels[e->kind];
    if (ch->knots != NULL) {
        return cam_err_image_channel;
    }
    *ch = cam_entry_channel(e, table);
    table->is_swung = table->is_swung || e->kind == (uint32_t)cam_kind_swing;
    table->has_stations =
        table->has_stations || (e->kind == (uint32_t)cam_kind_way && e->path != 0u);
    if (e->kind == (uint32_t)cam_kind_x) {
        table->is_ring_helix = e->path != 0u;
        table->x_min_nm = cam_sat_i32(values.low);
        table->x_max_nm = cam_sat_i32(values.high);
    }
    if (e->kind == (uint32_t)cam_kind_speed && values.high >= CAM_TABLE_RATIO_ONE) {
        table->ratio_max_q20 = (uint32_t)values.high + 1u; // 1 for the rounding of a share
    }
    return cam_ok;
}

/// Check a channel of any kind. A directory of lobes must come first: it makes slices patterns.
static cam_err_t check_channel(const cam_entry_t *e, uint32_t i, uint64_t *used, cam_table_t *table)
{
    if (e->kind == (uint32_t)cam_kind_lobes) {
        return i == 0u ? cam_lobes_check(e, used, table) : cam_err_image_channel;
    }
    if (e->kind == (uint32_t)cam_kind_passes) {
        return cam_entry_check_passes(e, used, table);
    }
    cam_extent_t values;
    cam_err_t err = cam_entry_check(e, table, used);
    err = err == cam_ok ? check_values(e, table, &values) : err;
    return err == cam_ok ? take_channel(e, values, table) : err;
}

/// Check the channels together: u and x are present, a ring-helix has a uniform speed and no way, a
/// way has the heights of the table, and stations where there are lobes, lobes have their patterns,
/// and the version is that of the kinds.
static cam_err_t check_together(uint32_t largest_kind, cam_table_t *table)
{
    const bool is_steady = table->speed.knots == NULL || !table->is_ring_helix;
    const bool is_complete = table->u.knots != NULL && table->x.knots != NULL && is_steady;
    const bool is_newer = largest_kind >= (uint32_t)cam_kind_newer;
    const bool is_known = is_newer == (word_at(table->image, at_version) == (uint32_t)version_1_1);
    const cam_channel_t *way = &table->way;
    const bool is_way_sound =
        way->knots == NULL || (way->z_first_nm == table->z_first_nm && !table->is_ring_helix &&
                               (table->has_stations || table->lobes == NULL) &&
                               (int64_t)way->z_first_nm + way->span_nm == table->z_last_nm);
    if (!is_complete || !is_known || !is_way_sound) {
        return is_newer || !is_complete ? cam_err_image_channel : cam_err_image_version;
    }
    const cam_err_t err = cam_feed_profile_check(table);
    return err == cam_ok && table->lobes != NULL ? cam_lobes_check_patterns(table) : err;
}

/// Check the channels one after the other, then together, and then the header's motion limits.
static cam_err_t check_channels(const uint8_t *image, cam_table_t *table)
{
    const uint32_t n = word_at(image, at_n_channels);
    uint64_t used = cam_table_header_size + (uint64_t)n * cam_table_entry_size;
    if (used > table->image_size) {
        return cam_err_image_layout;
    }
    cam_entry_t u = {0};
    uint32_t largest_kind = 0;
    table->ratio_max_q20 = CAM_TABLE_RATIO_ONE;
    for (uint32_t i = 0; i < n; i++) {
        cam_entry_t e;
        (void)memcpy(&e, image + cam_table_header_size + (size_t)i * cam_table_entry_size,
                     sizeof e);
        const cam_err_t err = check_channel(&e, i, &used, table);
        if (err != cam_ok) {
            return err;
        }
        u = e.kind == (uint32_t)cam_kind_u ? e : u;
        largest_kind = e.kind > largest_kind ? e.kind : largest_kind;
    }
    const cam_err_t err = check_together(largest_kind, table);
    return err == cam_ok ? check_motion_limits(&u, table) : err;
}

/// Measure from the knots of a sound table what feasibility needs and the format does not store.
static void measure(cam_table_t *table)
{
    const cam_x_slope_t slope = cam_x_slope_of(&table->x);
    table->x_slope_ppm = slope.slope_ppm;
    table->x_bend_ppm_per_mm = slope.bend_ppm_per_mm;
    table->spindle_demand = cam_peaks_of_speed(&table->speed);
    table->u3_peak_nm_per_rad3 = cam_peaks_third(&table->u);
    table->u2_rms_nm_per_rad2 = cam_peaks_rms_second(&table->u);
    if (table->lobes == NULL) { // slices of a lobe are not neighbours
        table->u_change = cam_peaks_of_change(&table->u);
    }
    if (table->is_swung) {
        table->swing = cam_peaks_of_swing(&table->angle);
    }
    if (table->is_swung && table->lobes == NULL) {
        table->swing_change = cam_peaks_of_change(&table->angle);
    }
}

cam_err_t cam_table_check(const void *image, size_t size, cam_table_t *table)
{
    *table = (cam_table_t){0};
    if (image == NULL || (uintptr_t)image % sizeof(uint32_t) != 0u) { // MISRA D18
        return cam_err_image_address;
    }
    cam_err_t err = check_frame(image, size);
    err = err == cam_ok ? check_header(image, table) : err;
    err = err == cam_ok ? check_channels(image, table) : err;
    if (err == cam_ok) {
        measure(table);
    } else {
        *table = (cam_table_t){0};
    }
    return err;
}
