// SPDX-License-Identifier: Apache-2.0
#include "fixture_image.h"
#include <math.h>   // sin, cos, lround
#include <string.h> // memcpy, memset

#define PI 3.14159265358979323846

/// Bit by bit, so that it shares nothing with the firmware's.
static uint32_t crc32_of(const uint8_t *bytes, size_t n)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < n; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = (crc >> 1) ^ ((crc & 1u) != 0u ? 0xEDB88320u : 0u);
        }
    }
    return ~crc;
}

void fixture_cosine_oval(double theta, double z_nm, double u[3])
{
    const double g = 200000.0 + 0.1 * z_nm;
    u[0] = g / 4.0 * (1.0 - cos(2.0 * theta));
    u[1] = g / 2.0 * sin(2.0 * theta);
    u[2] = g * cos(2.0 * theta);
}

void fixture_ellipse(double theta, double z_nm, double u[3])
{
    const double a = 46e6;
    const double b = 45.9e6;
    const double k = (a * a - b * b) / (b * b);
    const double w = 1.0 + k * sin(theta) * sin(theta);
    const double w1 = k * sin(2.0 * theta);
    const double w2 = 2.0 * k * cos(2.0 * theta);
    (void)z_nm;
    u[0] = a * k * sin(theta) * sin(theta) / (sqrt(w) * (sqrt(w) + 1.0));
    u[1] = a * pow(w, -1.5) * w1 / 2.0;
    u[2] = a * (pow(w, -1.5) * w2 / 2.0 - 0.75 * pow(w, -2.5) * w1 * w1);
}

static void barrel(double z_nm, double x[3])
{
    const double off = z_nm - 400000.0;
    x[0] = 46e6 - 2e-8 * off * off;
    x[1] = -4e-8 * off;
    x[2] = -4e-8;
}

fixture_part_t fixture_part_short(void)
{
    return (fixture_part_t){
        .n_slices = 11,
        .log2_knots = 5,
        .frac_bits = 7,
        .n_x = 5,
        .x_frac_bits = 8,
        .x_offset_nm = 46000000,
        .z_first_nm = 0,
        .z_last_nm = 1000000,
        .direction = 1,
        .spindle_mrpm = 2500000,
        .feed_nm = 100000,
        .u = fixture_cosine_oval,
        .x = barrel,
    };
}

void fixture_ratio(double theta, double z_nm, double r[3])
{
    const double swing = 0.375 - 1e-7 * z_nm;
    r[0] = 1.05 + swing * cos(2.0 * theta);
    r[1] = -2.0 * swing * sin(2.0 * theta);
    r[2] = -4.0 * swing * cos(2.0 * theta);
}

fixture_part_t fixture_part_modulated(void)
{
    fixture_part_t part = fixture_part_short();
    part.spindle_mrpm = 200000;
    part.speed = fixture_ratio;
    return part;
}

static void two_lobes(double theta, double z_nm, double u[3])
{
    (void)z_nm;
    u[0] = -50000.0 * (1.0 - cos(2.0 * theta));
    u[1] = -100000.0 * sin(2.0 * theta);
    u[2] = -200000.0 * cos(2.0 * theta);
}

void fixture_gamma(double theta, double z_nm, double g[3])
{
    const double most = 0.35 - 1e-10 * z_nm;
    g[0] = most * sin(2.0 * theta);
    g[1] = 2.0 * most * cos(2.0 * theta);
    g[2] = -4.0 * most * sin(2.0 * theta);
}

fixture_part_t fixture_part_swung(void)
{
    fixture_part_t part = fixture_part_short();
    part.spindle_mrpm = 60000;
    part.u = two_lobes;
    part.swing = fixture_gamma;
    return part;
}

fixture_part_t fixture_part_smallest(void)
{
    fixture_part_t part = fixture_part_short();
    part.n_slices = 2;
    part.log2_knots = 2;
    part.log2_repeat = 1;
    part.frac_bits = 3;
    part.n_x = 2;
    return part;
}

uint32_t fixture_image_get(const fixture_image_t *image, size_t at)
{
    uint32_t value = 0;
    memcpy(&value, image->bytes + at, sizeof value);
    return value;
}

void fixture_image_put(fixture_image_t *image, size_t at, uint32_t value)
{
    memcpy(image->bytes + at, &value, sizeof value);
}

static void put_i32(fixture_image_t *image, size_t at, int32_t value)
{
    fixture_image_put(image, at, (uint32_t)value);
}

size_t fixture_image_in(uint32_t channel, size_t field)
{
    return cam_table_header_size + (size_t)channel * cam_table_entry_size + field;
}

cam_knot_t *fixture_image_knots(fixture_image_t *image, uint32_t channel)
{
    const uint32_t at = fixture_image_get(image, fixture_image_in(channel, fixture_in_offset));
    return (cam_knot_t *)(void *)(image->bytes + at);
}

uint32_t fixture_image_n_knots(const fixture_image_t *image, uint32_t channel)
{
    return fixture_image_get(image, fixture_image_in(channel, fixture_in_n_slices))
           << fixture_image_get(image, fixture_image_in(channel, fixture_in_log2_knots));
}

void fixture_image_seal(fixture_image_t *image)
{
    fixture_image_put(image, fixture_at_crc, crc32_of(image->bytes + 24, image->size - 24));
}

static uint32_t magnitude(int32_t v)
{
    return v < 0 ? 0u - (uint32_t)v : (uint32_t)v;
}

/// Header promises from the bounds of u, a little generous for what lies between knots.
static void promise(fixture_image_t *image, uint32_t channel)
{
    const double lsb =
        ldexp(1.0, -(int)fixture_image_get(image, fixture_image_in(channel, fixture_in_frac_bits)));
    const int turn_shift =
        (int)(fixture_image_get(image, fixture_image_in(channel, fixture_in_log2_knots)) +
              fixture_image_get(image, fixture_image_in(channel, fixture_in_log2_repeat)));
    const double per_h = ldexp(1.0, turn_shift) / (2.0 * PI);
    const double offset =
        (int32_t)fixture_image_get(image, fixture_image_in(channel, fixture_in_offset_nm));
    const double low =
        (int32_t)fixture_image_get(image, fixture_image_in(channel, fixture_in_p_min));
    const double high =
        (int32_t)fixture_image_get(image, fixture_image_in(channel, fixture_in_p_max));
    const double v = fixture_image_get(image, fixture_image_in(channel, fixture_in_v_max));
    const double a = fixture_image_get(image, fixture_image_in(channel, fixture_in_a_max));
    put_i32(image, fixture_at_u_min, (int32_t)floor(offset + low * lsb));
    put_i32(image, fixture_at_u_max, (int32_t)ceil(offset + high * lsb));
    fixture_image_put(image, fixture_at_u1_peak, (uint32_t)fmin(2147483647.0, v * lsb * per_h + 1));
    fixture_image_put(image, fixture_at_u2_peak,
                      (uint32_t)fmin(2147483647.0, 2.0 * a * lsb * per_h * per_h + 1));
}

void fixture_image_remeasure(fixture_image_t *image, uint32_t channel)
{
    const cam_knot_t *k = fixture_image_knots(image, channel);
    int32_t low = k[0].p;
    int32_t high = k[0].p;
    uint32_t v = 0;
    uint32_t a = 0;
    for (uint32_t i = 0; i < fixture_image_n_knots(image, channel); i++) {
        low = k[i].p < low ? k[i].p : low;
        high = k[i].p > high ? k[i].p : high;
        v = magnitude(k[i].v) > v ? magnitude(k[i].v) : v;
        a = magnitude(k[i].a) > a ? magnitude(k[i].a) : a;
    }
    put_i32(image, fixture_image_in(channel, fixture_in_p_min), low);
    put_i32(image, fixture_image_in(channel, fixture_in_p_max), high);
    fixture_image_put(image, fixture_image_in(channel, fixture_in_v_max), v);
    fixture_image_put(image, fixture_image_in(channel, fixture_in_a_max), a);
    if (fixture_image_get(image, fixture_image_in(channel, fixture_in_kind)) == 1u) {
        promise(image, channel);
    }
}

static cam_knot_t quantise(const double f[3], double offset, double h, uint32_t frac_bits)
{
    const double scale = ldexp(1.0, (int)frac_bits);
    return (cam_knot_t){
        .p = (int32_t)lround((f[0] - offset) * scale),
        .v = (int32_t)lround(f[1] * h * scale),
        .a = (int32_t)lround(f[2] * h * h / 2.0 * scale),
    };
}

static void fill_u(cam_knot_t *knots, const fixture_part_t *part)
{
    const uint32_t n = 1u << part->log2_knots;
    const double h = 2.0 * PI / (double)(n << part->log2_repeat);
    for (uint32_t i = 0; i < part->n_slices * n; i++) {
        const double z = part->z_first_nm + (double)(i / n) / (part->n_slices - 1u) *
                                                ((double)part->z_last_nm - part->z_first_nm);
        double u[3];
        part->u((i % n) * h, z, u);
        knots[i] = quantise(u, part->u_offset_nm, h, part->frac_bits);
    }
}

static void fill_x(cam_knot_t *knots, const fixture_part_t *part)
{
    const double h = ((double)part->z_last_nm - part->z_first_nm) / (part->n_x - 1u);
    for (uint32_t i = 0; i < part->n_x; i++) {
        double x[3];
        part->x(part->z_first_nm + i * h, x);
        knots[i] = quantise(x, part->x_offset_nm, h, part->x_frac_bits);
    }
}

enum { n_more_slices = 3, log2_more_knots = 5 };

/// A channel over angle besides u.
typedef struct {
    uint32_t kind, frac_bits;
    int32_t offset;
    double unit; ///< of the function, in that of the channel
    fixture_surface_fn *f;
} more_t;

static more_t speed_of(const fixture_part_t *part)
{
    return (more_t){3u, 3u, CAM_TABLE_RATIO_ONE, CAM_TABLE_RATIO_ONE, part->speed};
}

static more_t swing_of(const fixture_part_t *part)
{
    return (more_t){4u, 2u, 0, 67108864.0 / (2.0 * PI), part->swing};
}

static void fill_more(cam_knot_t *knots, const fixture_part_t *part, const more_t *more)
{
    const uint32_t n = 1u << log2_more_knots;
    const double h = PI / (double)n;
    for (uint32_t i = 0; i < n_more_slices * n; i++) {
        const double z = part->z_first_nm + (double)(i / n) / (n_more_slices - 1) *
                                                ((double)part->z_last_nm - part->z_first_nm);
        double f[3];
        more->f((i % n) * h, z, f);
        for (int k = 0; k < 3; k++) {
            f[k] *= more->unit;
        }
        knots[i] = quantise(f, more->offset, h, more->frac_bits);
    }
}

/// What u and speed do together, on a grid finer than the knots.
static void promise_motion(fixture_image_t *image, const fixture_part_t *part)
{
    enum { n_angles = 720, n_heights = 8 };
    double peak[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < n_angles * (n_heights + 1); i++) {
        const double theta = PI * (i % n_angles) / n_angles;
        const double z = part->z_first_nm + (double)(i / n_angles) / n_heights *
                                                ((double)part->z_last_nm - part->z_first_nm);
        double u[3];
        double r[3];
        part->u(theta, z, u);
        part->speed(theta, z, r);
        peak[0] = fmax(peak[0], fabs(u[1] * r[0]));
        peak[1] = fmax(peak[1], fabs(u[2] * r[0] * r[0] + u[1] * r[0] * r[1]));
        peak[2] = fmax(peak[2], fabs(r[0] * r[1]));
    }
    fixture_image_put(image, fixture_at_u1_peak, (uint32_t)ceil(peak[0] * 1.0005));
    fixture_image_put(image, fixture_at_u2_peak, (uint32_t)ceil(peak[1] * 1.0005));
    fixture_image_put(image, fixture_at_spindle_peak, (uint32_t)ceil(peak[2] * 1.0005e6));
}

static uint32_t put_more(fixture_image_t *image, const fixture_part_t *part, const more_t *more,
                         uint32_t channel, uint32_t offset)
{
    const uint64_t span = (uint64_t)((int64_t)part->z_last_nm - part->z_first_nm);
    const uint32_t words[] = {
        more->kind,
        offset,
        (uint32_t)n_more_slices * (1u << log2_more_knots) * 12u,
        n_more_slices,
        log2_more_knots,
        1u,
        more->frac_bits,
        (uint32_t)part->z_first_nm,
        (uint32_t)part->z_last_nm,
        (uint32_t)((((uint64_t)(n_more_slices - 1u) << 48) + span / 2u) / span),
        (uint32_t)more->offset,
    };
    memcpy(image->bytes + fixture_image_in(channel, 0), words, sizeof words);
    fixture_image_put(image, fixture_at_n_channels, channel + 1u);
    return (offset + words[2] + 31u) & ~31u;
}

static uint32_t put_entry(fixture_image_t *image, const fixture_part_t *part, uint32_t channel,
                          uint32_t offset)
{
    const bool is_u = channel == fixture_u;
    const uint32_t n = is_u ? part->n_slices : part->n_x;
    const uint32_t log2_knots = is_u ? part->log2_knots : 0u;
    const uint64_t span = (uint64_t)((int64_t)part->z_last_nm - part->z_first_nm);
    const uint32_t words[] = {
        channel + 1u,
        offset,
        (n << log2_knots) * 12u,
        n,
        log2_knots,
        is_u ? part->log2_repeat : 0u,
        is_u ? part->frac_bits : part->x_frac_bits,
        (uint32_t)part->z_first_nm,
        (uint32_t)part->z_last_nm,
        (uint32_t)((((uint64_t)(n - 1u) << 48) + span / 2u) / span),
        (uint32_t)(is_u ? part->u_offset_nm : part->x_offset_nm),
    };
    memcpy(image->bytes + fixture_image_in(channel, 0), words, sizeof words);
    return (offset + words[2] + 31u) & ~31u;
}

static void put_header(fixture_image_t *image, const fixture_part_t *part)
{
    static const uint8_t magic[8] = {'C', 'A', 'M', 'T', 'A', 'B', 0x1A, 0x0A};
    const uint32_t words[] = {
        (uint32_t)part->z_first_nm,
        (uint32_t)part->z_last_nm,
        (uint32_t)part->direction,
        part->spindle_mrpm,
        part->feed_nm,
        100000, // depth
        1200000,
        400000,
        250000,
        3000000, // limits of the machine
    };
    memcpy(image->bytes, magic, sizeof magic);
    fixture_image_put(image, fixture_at_order, 0x01020304u);
    fixture_image_put(image, fixture_at_version, 1u);
    fixture_image_put(image, fixture_at_header_size, 128u);
    fixture_image_put(image, fixture_at_n_channels, 2u);
    memcpy(image->bytes + fixture_at_name, "short skirt", 11);
    memcpy(image->bytes + fixture_at_z_first, words, sizeof words);
    fixture_image_put(image, fixture_at_error, 500u);
}

void fixture_image_make(fixture_image_t *image, const fixture_part_t *part)
{
    memset(image, 0, sizeof *image);
    put_header(image, part);
    const more_t more[] = {speed_of(part), swing_of(part)};
    const uint32_t n_more = (part->speed != NULL ? 1u : 0u) + (part->swing != NULL ? 1u : 0u);
    const more_t *const first = part->speed != NULL ? more : more + 1;
    const uint32_t u_at = 256u + 64u * n_more;
    const uint32_t x_at = put_entry(image, part, fixture_u, u_at);
    image->size = put_entry(image, part, fixture_x, x_at);
    for (uint32_t i = 0; i < n_more; i++) {
        const uint32_t channel = fixture_speed + i;
        image->size = put_more(image, part, &first[i], channel, (uint32_t)image->size);
        fill_more(fixture_image_knots(image, channel), part, &first[i]);
        fixture_image_remeasure(image, channel);
    }
    fixture_image_put(image, fixture_at_image_size, (uint32_t)image->size);
    fill_u(fixture_image_knots(image, fixture_u), part);
    fill_x(fixture_image_knots(image, fixture_x), part);
    fixture_image_remeasure(image, fixture_u);
    fixture_image_remeasure(image, fixture_x);
    if (part->speed != NULL) {
        promise_motion(image, part);
    }
    fixture_image_seal(image);
}
