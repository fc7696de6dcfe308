// SPDX-License-Identifier: Apache-2.0
#include "fuzz_draw.h"
#include "fuzz_expect.h" // FUZZ_EXPECT
#include "fuzz_rig.h"    // fuzz_rig
#include <math.h>        // exp2, fabs, log2

/// What is made of a number that was drawn.
typedef enum {
    plain,
    or_0, ///< the lowest sixteenth is 0, which has a meaning of its own, as of a gain or of a jerk
    outwards, ///< ... and else negative
    of_k1,    ///< ... and else that multiple of the square of k1: 1 / (2 damping)^2
} kind_t;

/// A parameter of the machine, drawn from a range of magnitudes.
typedef struct {
    cam_param_id_t id;
    kind_t kind;
    double least, most;
} draw_t;

/// Limits first, because gains and jerks are refused by them.
static const draw_t draws[fuzz_draw_n] = {
    {cam_param_u_speed_um_per_s, plain, 1e3, 1e7},
    {cam_param_u_acceleration_mm_per_s2, plain, 1e3, 1e7},
    {cam_param_u_stroke_nm, plain, 1e5, 3e7},
    {cam_param_u_retract_nm, outwards, 1e4, 1.5e7},
    {cam_param_u_jerk_m_per_s3, or_0, 1e2, 2e9},
    {cam_param_k1_ns, or_0, 1e4, 1e8},
    {cam_param_k2_us2, of_k1, 0.0025, 1.0},
    {cam_param_x_speed_um_per_s, plain, 1e3, 1e7},
    {cam_param_x_acceleration_mm_per_s2, plain, 1e1, 1e6},
    {cam_param_x_jerk_m_per_s3, or_0, 1e0, 2e9},
    {cam_param_z_speed_um_per_s, plain, 1e3, 1e7},
    {cam_param_z_acceleration_mm_per_s2, plain, 1e1, 1e6},
    {cam_param_z_jerk_m_per_s3, or_0, 1e0, 2e9},
    {cam_param_xz_lag_ns, or_0, 1e5, 1e8},
    {cam_param_x_clearance_nm, plain, 1e5, 3e7},
    {cam_param_engage_turns, plain, 1, 100},
    {cam_param_disengage_turns, plain, 1, 100},
    {cam_param_feed_ramp_turns, plain, 1, 100},
    {cam_param_feed_nm, or_0, 1e3, 1e7},
    {cam_param_u_jog_um_per_s, plain, 1e2, 1e6},
    {cam_param_x_jog_um_per_s, plain, 1e2, 1e6},
    {cam_param_z_jog_um_per_s, plain, 1e2, 1e6},
    {cam_param_x_low_nm, or_0, 3e7, 4.7e7},
    {cam_param_x_high_nm, or_0, 4.7e7, 1e8},
    {cam_param_z_low_nm, outwards, 1e5, 1e9},
    {cam_param_z_high_nm, or_0, 1e6, 1e9},
    {cam_param_spindle_limit_mrpm, plain, 1e5, 6e7},
    {cam_param_spindle_acceleration_mrad_per_s2, plain, 2.6e6, 2e9},
    {cam_param_observer_bandwidth_mHz, plain, 2e4, 5e6},
};
enum { least_code = 4096, most_code = 65535 };

/// @return 0, or a value whose logarithm is as likely as any other
static int32_t drawn(const draw_t *d, uint16_t code)
{
    const double share = (double)(code - 1) / (most_code - 1);
    const double size = exp2(log2(d->least) + share * (log2(d->most) - log2(d->least)));
    const double k1_us = fuzz_rig.machine.params.k1_ns / 1e3;
    const double value = d->kind == of_k1 ? size * k1_us * k1_us : size;
    const int32_t whole = (int32_t)(value < INT32_MAX ? value : INT32_MAX);
    return d->kind != plain && code < (uint16_t)least_code ? 0
           : d->kind == outwards                           ? -whole
                                                           : whole;
}

/// @param code  0: the default
static void draw(const draw_t *d, uint16_t code)
{
    if (code == 0u) {
        return;
    }
    const cam_err_t err = cam_machine_set_param(&fuzz_rig.machine, d->id, drawn(d, code));
    if (fuzz_rig_is_traced()) {
        (void)printf("%s = %d: %d\n", cam_param_info(d->id)->name, (int)drawn(d, code), (int)err);
    }
    fuzz_rig_tick();
}

void fuzz_draw_all(fuzz_bytes_t *b)
{
    for (uint32_t i = 0; i < (uint32_t)fuzz_draw_n; i++) {
        draw(&draws[i], fuzz_u16(b));
    }
}

void fuzz_draw_write(uint8_t *bytes, cam_param_id_t id, double value)
{
    uint32_t i = 0;
    while (i < (uint32_t)fuzz_draw_n && draws[i].id != id) {
        i++;
    }
    FUZZ_EXPECT(i < (uint32_t)fuzz_draw_n, "parameter %u is not drawn", (unsigned)id);
    const draw_t *d = &draws[i];
    const double size = value != 0.0 ? fabs(value) : d->least;
    const double share = log2(size / d->least) / log2(d->most / d->least);
    const uint32_t code = 1u + (uint32_t)(share * (most_code - 1) + 0.5);
    bytes[2u * i] = (uint8_t)code;
    bytes[2u * i + 1u] = (uint8_t)(code >> 8);
}
