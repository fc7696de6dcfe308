// SPDX-License-Identifier: Apache-2.0
// Iterative learning of whatever the interrupt may measure: what is learned stays within its
// limits, and no step of what is blended in is larger than cam_learning.h allows.
#include "cam_learning.h"
#include "fixture_random.h"
#include "fuzz_bytes.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include <math.h>

enum { most_turns = 40, polls = 40 };

static cam_turn_bins_t bins;
static cam_learned_t in_force;

static uint32_t share(fuzz_bytes_t *b, uint32_t most)
{
    return fuzz_u16(b) % (most + 1u);
}

static cam_ilc_setup_t drawn(fuzz_bytes_t *b)
{
    const int32_t least_q16 = -(int32_t)share(b, 40) * 65536;
    return (cam_ilc_setup_t){
        .reason = (cam_ilc_reason_t)share(b, cam_ilc_n_reasons - 1),
        .n_harmonics = share(b, cam_ilc_harmonics),
        .gain_q16 = (int32_t)share(b, 39321),
        .cut_gain_q16 = (int32_t)share(b, 13107),
        .probe_q6 = 64 * (100 + (int32_t)share(b, 4900)),
        .ripple_turns = share(b, 64),
        .scale_nm = (int32_t)share(b, 10000),
        .least_ripple_q32 = (int32_t)share(b, 65535),
        .count_urad = (int32_t)share(b, 50000),
        .most_q6 = 64 * cam_ilc_most_nm,
        .k1_q16 = (int32_t)share(b, 100) * 65536,
        .k2_q16 = (int32_t)share(b, 1000) * 65536,
        .k1_least_q16 = least_q16,
        .k1_most_q16 = (int32_t)share(b, 40) * 65536,
        .k2_least_q16 = 4 * least_q16,
        .k2_most_q16 = (int32_t)share(b, 160) * 65536,
        .friction_q6 = 64 * (int32_t)share(b, cam_ilc_most_nm),
        .depth_nm = 100 * (int32_t)share(b, 50000),
        .between_q16 = (int32_t)share(b, 8192),
        .is_u_moving = (fuzz_u8(b) & 1u) != 0u,
        .angle_step_q23 = 1 + (int32_t)share(b, 32766),
        .ripple_from_q32 = (int32_t)share(b, 65535) << 8,
        .observer_step_q23 = 1 + (int32_t)share(b, 32766),
        .eccentricity = {(int32_t)fuzz_u16(b) << 4, (int32_t)fuzz_u16(b) << 4}};
}

/// Write a turn of the interrupt's: two waves of the set-point and of its error, and noise.
static void play(fuzz_bytes_t *b, uint32_t number, cam_state_t state)
{
    const uint32_t n_ticks = 16u + share(b, 4000);
    const uint32_t order = 1u + fuzz_u8(b) % 20u;
    const double set_nm = 20.0 * fuzz_u16(b), error_nm = fuzz_u16(b) * (fuzz_u8(b) & 7u);
    const uint32_t noise = fuzz_u16(b), flags = fuzz_u8(b);
    const uint32_t bank = number & 1u;
    fixture_random_t random = {number};
    for (uint32_t i = 0; i < n_ticks; i++) {
        const uint32_t dice = fixture_random_u32(&random);
        const double at = 6.283185307179586 * (i + 0.5) / n_ticks;
        cam_turn_bin_t *bin = &bins.bin[bank * cam_turn_bins_n + i * cam_turn_bins_n / n_ticks];
        bin->n++;
        bin->u_nm += (int32_t)lround(set_nm * cos(2.0 * at));
        bin->error_q6 += (int32_t)lround(64.0 * error_nm * sin(order * at)) +
                         (int32_t)((dice >> 16) * noise >> 16);
        bin->angle_q24 += (int32_t)((dice >> 8 & 0xFFu) * (flags >> 4));
    }
    bins.closed[bank] = (cam_turn_t){
        .turn = number,
        .state = state,
        .is_steady = (flags & 3u) != 3u,
        .is_level = (flags & 12u) != 12u,
        .speed_q32 = (int32_t)(UINT32_MAX / n_ticks / 1024u * (1020u + (flags >> 2 & 7u))),
        .scale_q30 = 1 << (30u - (flags & 1u)),
        .phase_q32 = fuzz_i32(b) >> (flags & 31u),
        .z_begin_nm = (int32_t)number * 100000,
        .z_end_nm = (int32_t)number * 100000 + fuzz_u16(b)};
    bins.closed_turn[bank] = number | 1u << 24;
    bins.at_q8 = (number + 1u) << 8 | 10u;
}

static void expect_step(const char *name, uint32_t i, int32_t from, int32_t to, int32_t most)
{
    const int32_t step = to > from ? to - from : from - to;
    FUZZ_EXPECT(step <= most, "%s %u goes from %d to %d", name, (unsigned)i, (int)from, (int)to);
}

/// At most 1000 nm and 131 units of an angle in a rehearsal, 50 nm and 13 in any other work.
static void blend(cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const cam_state_t state = (cam_state_t)t->state;
    const bool is_rehearsal = state == cam_state_rehearsing;
    const bool is_free = state == cam_state_engaging && !s->is_u_moving; // the angles move nothing
    for (uint32_t i = 0; i < 30u; i++) {
        const uint32_t at_q8 = bins.at_q8 + 8u * i;
        const cam_learned_t before = in_force;
        if (!cam_ilc_is_blending(t, at_q8)) {
            continue;
        }
        cam_ilc_blend(t, s, at_q8, &in_force);
        for (uint32_t j = 0; cam_state_is_in_work(state) && j < cam_learned_points + 2u; j++) {
            expect_step("point", j, before.c[j], in_force.c[j], is_rehearsal ? 1000 : 50);
            const int32_t most_q23 = is_free ? INT16_MAX : is_rehearsal ? 131 : 13;
            expect_step("angle", j, before.d[j], in_force.d[j], most_q23);
            expect_step("shown angle", j, before.dm[j], in_force.dm[j], most_q23);
        }
    }
}

static void judge(const cam_ilc_t *t, const cam_ilc_setup_t *s)
{
    const cam_ilc_status_t status = cam_ilc_status(t, s, 20000);
    fuzz_note_words(&status, sizeof status);
    fuzz_note_words(&in_force, sizeof in_force);
    for (uint32_t k = 0; k < cam_ilc_n_values; k++) {
        fuzz_note(cam_ilc_get(t, k));
    }
    const int32_t most_q6 = 64 * cam_ilc_most_nm;
    FUZZ_EXPECT(status.phase < cam_ilc_n_phases && status.reason < cam_ilc_n_reasons,
                "phase %d, %d", (int)status.phase, (int)status.reason);
    FUZZ_EXPECT(s->k1_least_q16 <= t->drive.k1_q16 && t->drive.k1_q16 <= s->k1_most_q16, "k1 is %d",
                (int)t->drive.k1_q16);
    FUZZ_EXPECT(s->k2_least_q16 <= t->drive.k2_q16 && t->drive.k2_q16 <= s->k2_most_q16, "k2 is %d",
                (int)t->drive.k2_q16);
    FUZZ_EXPECT(-s->friction_q6 <= t->drive.friction_q6 && t->drive.friction_q6 <= most_q6,
                "friction is %d", (int)t->drive.friction_q6);
    FUZZ_EXPECT(status.correction_nm <= 20u * cam_ilc_most_nm, "corrections: %u nm",
                (unsigned)status.correction_nm);
    for (uint32_t k = 0; k < cam_ilc_n_values; k++) {
        cam_ilc_t copy = *t;
        FUZZ_EXPECT(cam_ilc_set(&copy, k, cam_ilc_get(t, k)), "value %u, %d, cannot be set",
                    (unsigned)k, (int)cam_ilc_get(t, k));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const cam_state_t states[] = {
        cam_state_rehearsing, cam_state_rehearsing, cam_state_engaging, cam_state_cutting,
        cam_state_cutting,    cam_state_ready,      cam_state_off,      cam_state_fault};
    fuzz_bytes_t b = {.at = data, .n = size};
    const cam_ilc_setup_t setup = drawn(&b);
    cam_ilc_t ilc;
    cam_ilc_init(&ilc);
    bins = (cam_turn_bins_t){0};
    in_force = (cam_learned_t){0};
    cam_state_t state = cam_state_off;
    for (uint32_t turn = 1; turn <= (uint32_t)most_turns && b.n > 0u; turn++) {
        const uint8_t what = fuzz_u8(&b);
        state = (what & 0x80u) != 0u ? states[what & 7u] : state;
        play(&b, turn, state);
        for (uint32_t i = 0; i < (uint32_t)polls; i++) {
            cam_ilc_poll(&ilc, &setup, state, &bins);
        }
        blend(&ilc, &setup);
        judge(&ilc, &setup);
    }
    return 0;
}
