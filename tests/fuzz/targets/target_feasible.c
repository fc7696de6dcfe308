// SPDX-License-Identifier: Apache-2.0
// Any parameters with the rig's three tables and a shaft of three lobes: both forms of the check
// agree, and every configuration built is within the ranges of the proof.
#include "cam_build.h"
#include "cam_feasible.h"
#include "cam_fix.h" // cam_clamp_i64
#include "fixture_image.h"
#include "fixture_shaft.h"
#include "fuzz_bytes.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_rig.h"
#include "hal_host.h"

enum { n_tables = fuzz_rig_n_parts + 1, most_changes = 12, clock_hz = 480000000 };

static cam_table_t tables[n_tables];

static void check(uint32_t i, const void *image, size_t size)
{
    FUZZ_EXPECT(cam_table_check(image, size, &tables[i]) == cam_ok, "table %u", (unsigned)i);
}

static void make_tables(void)
{
    static fixture_image_t shaft;
    for (uint32_t i = 0; i < (uint32_t)fuzz_rig_n_parts; i++) {
        size_t size;
        const void *image = fuzz_rig_image(i, &size);
        check(i, image, size);
    }
    const fixture_shaft_t three = fixture_shaft_three();
    fixture_shaft_make(&shaft, &three);
    check(fuzz_rig_n_parts, shaft.bytes, shaft.size);
}

/// @return 0 to 2^8 times the default, an end of the range, or a number within it; not yet clamped
static int64_t value_of(fuzz_bytes_t *b, const cam_param_info_t *info)
{
    const uint8_t how = fuzz_u8(b);
    const uint32_t code = fuzz_u32(b);
    const uint64_t span = (uint64_t)((int64_t)info->max - info->min);
    if (how < 192u && info->def != 0) {
        return (info->def * (int64_t)(code & 0xFFFFu)) >> (8u + how % 9u);
    }
    return how % 8u == 0u   ? info->min
           : how % 8u == 1u ? info->max
                            : info->min + (int64_t)((code % (span + 1u)) >> (how % 32u));
}

/// @return the defaults (with a weak loop for a force drive), with up to 12 parameters changed
static cam_params_t drawn(fuzz_bytes_t *b, bool takes_force)
{
    cam_params_t params = cam_param_defaults();
    if (takes_force) {
        params.servo_integral_mHz = 0;
        params.servo_pole_hz = 100;
        params.servo_crossover_hz = 20;
    }
    for (uint32_t n = fuzz_u8(b) % ((uint32_t)most_changes + 1u); n > 0u; n--) {
        const cam_param_id_t id = (cam_param_id_t)(fuzz_u16(b) % (uint32_t)cam_n_params);
        const cam_param_info_t *info = cam_param_info(id);
        const int64_t value = value_of(b, info);
        fuzz_try(cam_param_set(&params, id, (int32_t)cam_clamp_i64(value, info->min, info->max)));
    }
    return params;
}

/// A slow drive of U in a short stroke: only there the knots are read for the command.
static void draw_slow_drive(fuzz_bytes_t *b, cam_params_t *params)
{
    fuzz_try(cam_param_set(params, cam_param_k1_ns, 50 * fuzz_u16(b)));
    fuzz_try(cam_param_set(params, cam_param_k2_us2, 16 * fuzz_u16(b)));
    fuzz_try(cam_param_set(params, cam_param_u_stroke_nm, 1000 + 10 * fuzz_u16(b)));
}

static void note_refusal(cam_refusal_t r)
{
    fuzz_note(r.err);
    fuzz_note(r.param);
    fuzz_note(r.needed);
    fuzz_note(r.limit);
    fuzz_note(r.speed_mrpm);
    fuzz_note(r.highest_mrpm);
    fuzz_note(r.largest_feed_nm);
}

static void note_cut(const cam_table_t *table, const cam_params_t *p, uint32_t mrpm, uint32_t hz)
{
    cam_demands_t axes;
    (void)cam_feasible_demands(table, p, mrpm, hz, &axes);
    for (uint32_t i = 0; i < (uint32_t)cam_n_demands; i++) {
        fuzz_note((int64_t)axes.of[i].needed);
        fuzz_note(axes.of[i].limit);
    }
    const cam_refusal_t found = cam_feasible(table, p, mrpm, hz);
    FUZZ_EXPECT(found.err == cam_feasible_check(table, p, mrpm, hz), "%d", (int)found.err);
    note_refusal(found);
    fuzz_note(cam_demand_half_stroke_nm(table, p));
    fuzz_note(cam_demand_clearance_nm(table, p));
    fuzz_note(cam_derived_limits_following_nm(p, table));
    fuzz_note(cam_derived_limits_approach_nm(p, table, hz));
    fuzz_note(cam_derived_limits_averaging_mrpm(p, mrpm, hz));
    fuzz_note(cam_derived_limits_form_pm(table));
    fuzz_note(cam_derived_limits_count_pm(table, p->counts_per_turn));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static cam_config_t config;
    fuzz_bytes_t b = {.at = data, .n = size};
    if (tables[0].image == NULL) {
        make_tables();
    }
    const uint32_t hz = fuzz_rig_hz(fuzz_u8(&b));
    const cam_table_t *table = &tables[fuzz_u8(&b) % (uint32_t)n_tables];
    const uint32_t mrpm =
        (uint32_t)((uint64_t)table->spindle_mrpm * (fuzz_u8(&b) + 1u) / 128u + 1u);
    hal_host_reset(hz);
    const uint8_t how = fuzz_u8(&b);
    const bool takes_force = (how & 1u) != 0u;
    hal_host.slow.force.quantum_un = takes_force ? 20000 : 0;
    cam_params_t params = drawn(&b, takes_force);
    if ((how & 2u) != 0u) {
        draw_slow_drive(&b, &params);
    }
    note_refusal(cam_gains_check(&params, hz));
    note_refusal(cam_derived_limits_check(&params, hz));
    note_cut(table, &params, mrpm, hz);
    const cam_refusal_t refusal = cam_build_config(&config, &params, table, mrpm, hz, clock_hz);
    note_refusal(refusal);
    if (refusal.err == cam_ok) {
        fuzz_rig_walk_config(&config);
    }
    return 0;
}
