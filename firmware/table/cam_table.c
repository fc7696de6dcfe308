// SPDX-License-Identifier: Apache-2.0
#include "cam_table.h"
#include "cam_x_slope.h"         // cam_x_slope_of
#include "cam_entry.h"           // cam_entry_check
#include "cam_extent.h"          // cam_extent_widened
#include "cam_fix.h"             // cam_is_between
#include "cam_lobes.h"           // cam_lobes_check
#include "cam_spindle_demand.h"  // cam_spindle_demand_of
#include "cam_peaks.h"           // cam_peaks_of_swing
#include "cam_passes.h"          // cam_passes_check
#include "cam_header_limits.h"   // cam_header_limits_check
#include "cam_signature_block.h" // cam_signature_block_follows
#include "cam_feed_profile.h"    // cam_feed_profile_check
#include <stdbool.h>             // bool
#include <string.h>              // memcpy, memcmp

_Static_assert(sizeof(cam_knot_t) == 12, "a knot is three words of the image");

/// Offsets of the header's fields in bytes: TABLE_FORMAT.md, "Header".
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
};

/// Known versions; kinds from cam_kind_newer on make it the second.
enum { version_1_0 = 1, version_1_1 = 0x10001 };

/// Header fields from at_z_first on, in the order of the image.
typedef struct {
    int32_t z_first_nm, z_last_nm, direction;
    uint32_t spindle_mrpm, feed_nm, depth_nm;
    uint32_t limit_u_stroke_nm, limit_u_speed_um_per_s, limit_u_acceleration_mm_per_s2,
        limit_spindle_mrpm;
    int32_t u_min_nm, u_max_nm;
    uint32_t u1_peak_nm_per_rad, u2_peak_nm_per_rad2, error_pm, spindle_peak_ppm_per_rad;
} header_fields_t;
_Static_assert(at_z_first + sizeof(header_fields_t) == cam_table_header_size, "as in the format");

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
    const bool is_signed = stored >= (size_t)cam_table_header_size && stored < offered &&
                           offered - stored == (size_t)cam_signature_block_size &&
                           cam_signature_block_follows(image, stored, offered);
    const size_t size = is_signed ? stored : offered;
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
    if (stored != size || size % cam_entry_align != 0u) {
        return cam_err_image_size;
    }
    return cam_crc32(0, image + crc_from, size - crc_from) == word_at(image, at_crc)
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

/// Check the ranges of the header's fields, and the part name.
static cam_err_t check_header(const uint8_t *image, header_fields_t *h)
{
    (void)memcpy(h, image + at_z_first, sizeof *h);
    const uint32_t n_channels = word_at(image, at_n_channels);
    const bool is_sound =
        word_at(image, at_header_size) == cam_table_header_size &&
        cam_is_between(n_channels, 1, cam_table_max_channels) &&
        cam_is_between(h->z_first_nm, -cam_entry_max_height_nm / 2, cam_entry_max_height_nm / 2) &&
        cam_is_between(h->z_last_nm, (int64_t)h->z_first_nm + 1, cam_entry_max_height_nm / 2) &&
        (h->direction == 1 || h->direction == -1) &&
        cam_is_between(h->spindle_mrpm, 1, cam_table_max_mrpm) &&
        cam_is_between(h->feed_nm, 1, cam_table_max_feed_nm) &&
        cam_is_between(h->depth_nm, 0, INT32_MAX) &&
        cam_is_between(h->limit_u_stroke_nm, 1, max_stroke_nm) &&
        cam_is_between(h->limit_u_speed_um_per_s, 1, INT32_MAX) &&
        cam_is_between(h->limit_u_acceleration_mm_per_s2, 1, INT32_MAX) &&
        cam_is_between(h->limit_spindle_mrpm, 1, cam_table_max_mrpm) &&
        cam_is_between(h->u_min_nm, -max_u_nm, max_u_nm) &&
        cam_is_between(h->u_max_nm, h->u_min_nm, max_u_nm) &&
        cam_is_between(h->u1_peak_nm_per_rad, 0, INT32_MAX) &&
        cam_is_between(h->u2_peak_nm_per_rad2, 0, INT32_MAX) &&
        cam_is_between(h->spindle_peak_ppm_per_rad, 0, max_spindle_ppm);
    return is_sound ? check_name(image + at_name) : cam_err_image_header;
}

/// Find the range of a channel's values, between the knots too, and check it: u against the
/// header's limits, which with lobes include 0 (the middle of a gap), other channels against the
/// limits of their kind. Nothing needs the range of a way between its knots.
static cam_err_t check_values(const cam_entry_t *e, const header_fields_t *h,
                              const cam_entry_place_t *in, cam_extent_t *values)
{
    const cam_channel_t ch = cam_entry_channel(e, in->image);
    const bool is_around = cam_entry_is_over_angle(e);
    if (e->kind == (uint32_t)cam_kind_u) {
        *values = cam_extent_widened(&ch, is_around, (cam_extent_t){h->u_min_nm, h->u_max_nm});
        const bool is_kept = values->low == h->u_min_nm && values->high == h->u_max_nm &&
                             (!in->has_lobes || cam_is_between(0, values->low, values->high));
        return is_kept ? cam_ok : cam_err_image_limits;
    }
    *values = cam_extent_of_knots(&ch, e->p_min, e->p_max);
    if (e->kind != (uint32_t)cam_kind_way) {
        *values = cam_extent_widened(&ch, is_around, *values);
    }
    return cam_entry_is_in_unit(e, *values) ? cam_ok : cam_err_image_limits;
}

/// @return the table's channel of a kind; swing and contact exclude each other and share one
static cam_channel_t *channel_of(cam_table_t *table, uint32_t kind)
{
    switch (kind) {
    case cam_kind_u:
        return &table->u;
    case cam_kind_x:
        return &table->x;
    case cam_kind_speed:
        return &table->speed;
    case cam_kind_way:
        return &table->way;
    default:
        return &table->angle;
    }
}

/// @return a derivative per knot interval, converted to per rad, rounded down
static int64_t knot_per_rad(int64_t x, uint32_t log2_knots_per_turn)
{
    return cam_per_rad(x) << log2_knots_per_turn;
}

/// Check the header's motion limits. At uniform speed they must cover the bounds of u's knots; with
/// a speed channel every knot is evaluated.
static cam_err_t check_motion_limits(const cam_entry_t *u, const header_fields_t *h,
                                     cam_table_t *table)
{
    table->u1_peak_nm_per_rad = h->u1_peak_nm_per_rad;
    table->u2_peak_nm_per_rad2 = h->u2_peak_nm_per_rad2;
    table->spindle_peak_ppm_per_rad = h->spindle_peak_ppm_per_rad;
    if (table->speed.knots != NULL) {
        return cam_header_limits_check(table);
    }
    const uint32_t log2_knots = u->log2_knots + u->log2_repeat; // per turn
    const int64_t u1 = knot_per_rad(u->v_max, log2_knots) >> u->frac_bits;
    const int64_t u2 =
        knot_per_rad(knot_per_rad(INT64_C(2) * u->a_max, log2_knots), log2_knots) >> u->frac_bits;
    const bool is_covered = u1 <= (int64_t)h->u1_peak_nm_per_rad &&
                            u2 <= (int64_t)h->u2_peak_nm_per_rad2 &&
                            h->spindle_peak_ppm_per_rad == 0u;
    return is_covered ? cam_ok : cam_err_image_limits;
}

/// Put a checked channel into the table.
/// @return false if the table has one of this kind, or swing and contact
static bool take_channel(const cam_entry_t *e, const uint8_t *image, cam_extent_t values,
                         cam_table_t *table)
{
    cam_channel_t *ch = channel_of(table, e->kind);
    if (ch->knots != NULL) {
        return false;
    }
    *ch = cam_entry_channel(e, image);
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
    return true;
}

/// Check a channel of any kind. A directory of lobes must come first: it makes slices patterns.
static cam_err_t check_channel(const cam_entry_t *e, uint32_t i, const header_fields_t *h,
                               const uint8_t *image, uint64_t *used, cam_table_t *table)
{
    const cam_entry_place_t in = {.image = image,
                                  .image_size = word_at(image, at_image_size),
                                  .z_first_nm = h->z_first_nm,
                                  .z_last_nm = h->z_last_nm,
                                  .has_lobes = table->lobes != NULL};
    if (e->kind == (uint32_t)cam_kind_lobes) {
        return i == 0u ? cam_lobes_check(e, &in, used, table) : cam_err_image_channel;
    }
    if (e->kind == (uint32_t)cam_kind_passes) {
        return cam_passes_check(e, &in, used, table);
    }
    cam_extent_t values;
    cam_err_t err = cam_entry_check(e, &in, used);
    if (err == cam_ok) {
        err = check_values(e, h, &in, &values);
    }
    if (err != cam_ok) {
        return err;
    }
    return take_channel(e, image, values, table) ? cam_ok : cam_err_image_channel;
}

/// Check the channels together: u and x are present, a ring-helix has a uniform speed and no way, a
/// way has the heights of the table, stations if and only if there are lobes, lobes have their
/// patterns, and the version is that of the kinds.
static cam_err_t check_together(const uint8_t *image, uint32_t largest_kind,
                                const header_fields_t *h, cam_table_t *table)
{
    const bool is_steady = table->speed.knots == NULL || !table->is_ring_helix;
    const bool is_complete = table->u.knots != NULL && table->x.knots != NULL && is_steady;
    const bool is_newer = largest_kind >= (uint32_t)cam_kind_newer;
    const bool is_known = is_newer == (word_at(image, at_version) == (uint32_t)version_1_1);
    const cam_channel_t *way = &table->way;
    const bool is_way_sound =
        way->knots == NULL || (way->z_first_nm == h->z_first_nm && !table->is_ring_helix &&
                               table->has_stations == (table->lobes != NULL) &&
                               (int64_t)way->z_first_nm + way->span_nm == (int64_t)h->z_last_nm);
    if (!is_complete || !is_known || !is_way_sound) {
        return is_newer || !is_complete ? cam_err_image_channel : cam_err_image_version;
    }
    const cam_err_t err = cam_feed_profile_check(table);
    return err == cam_ok && table->lobes != NULL ? cam_lobes_check_patterns(table) : err;
}

/// Check the channels one after the other, then together, and then the header's motion limits.
static cam_err_t check_channels(const uint8_t *image, const header_fields_t *h, cam_table_t *table)
{
    const uint32_t n = word_at(image, at_n_channels);
    uint64_t used = cam_table_header_size + (uint64_t)n * cam_table_entry_size;
    if (used > word_at(image, at_image_size)) {
        return cam_err_image_layout;
    }
    cam_entry_t u = {0};
    uint32_t largest_kind = 0;
    table->ratio_max_q20 = CAM_TABLE_RATIO_ONE;
    for (uint32_t i = 0; i < n; i++) {
        cam_entry_t e;
        (void)memcpy(&e, image + cam_table_header_size + (size_t)i * cam_table_entry_size,
                     sizeof e);
        const cam_err_t err = check_channel(&e, i, h, image, &used, table);
        if (err != cam_ok) {
            return err;
        }
        u = e.kind == (uint32_t)cam_kind_u ? e : u;
        largest_kind = e.kind > largest_kind ? e.kind : largest_kind;
    }
    const cam_err_t err = check_together(image, largest_kind, h, table);
    return err == cam_ok ? check_motion_limits(&u, h, table) : err;
}

/// Describe a table whose header and channels are good. Figures that feasibility needs and the
/// format does not store are measured from the knots.
static void describe(const uint8_t *image, const header_fields_t *h, cam_table_t *table)
{
    (void)memcpy(table->name, image + at_name, sizeof table->name);
    table->z_first_nm = h->z_first_nm;
    table->z_last_nm = h->z_last_nm;
    table->direction = h->direction;
    table->spindle_mrpm = h->spindle_mrpm;
    table->feed_nm = h->feed_nm;
    table->depth_nm = h->depth_nm;
    table->limit_u_stroke_nm = h->limit_u_stroke_nm;
    table->limit_u_speed_um_per_s = h->limit_u_speed_um_per_s;
    table->limit_u_acceleration_mm_per_s2 = h->limit_u_acceleration_mm_per_s2;
    table->limit_spindle_mrpm = h->limit_spindle_mrpm;
    table->u_min_nm = h->u_min_nm;
    table->u_max_nm = h->u_max_nm;
    table->error_pm = h->error_pm;
    table->crc32 = word_at(image, at_crc);
    table->image = image;
    table->image_size = word_at(image, at_image_size);
    const cam_x_slope_t slope = cam_x_slope_of(&table->x);
    table->x_slope_ppm = slope.slope_ppm;
    table->x_bend_ppm_per_m = slope.bend_ppm_per_m;
    table->spindle_demand = cam_spindle_demand_of(&table->speed);
    const cam_change_t none = {0}; // slices of a lobe are not neighbours
    table->u_change = table->lobes != NULL ? none : cam_peaks_of_change(&table->u);
    table->u3_peak_nm_per_rad3 = cam_peaks_third(&table->u);
    if (table->is_swung) {
        table->swing = cam_peaks_of_swing(&table->angle);
        table->swing_change = table->lobes != NULL ? none : cam_peaks_of_change(&table->angle);
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
    describe(image, &header, &found);
    *table = found;
    return cam_ok;
}
