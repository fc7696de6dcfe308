// SPDX-License-Identifier: Apache-2.0
// The position loop of any force drive: the design refuses its parameters, or its coefficients are
// within the ranges of cam_servo.h, and then no input drives the force out of its limits.
#include "cam_param.h"
#include "cam_feasible_inner.h"
#include "fuzz_bytes.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"

enum { most_steps = 200 };

/// @return a number of a range, on a logarithmic scale from its lower end on
static int32_t within(fuzz_bytes_t *b, int64_t least, int64_t most)
{
    const uint8_t magnitude = fuzz_u8(b);
    const int64_t span = (most - least) >> (magnitude & 31u);
    return (int32_t)(least + (span > 0 ? fuzz_u32(b) % (uint32_t)(span + 1) : 0));
}

static int32_t parameter(fuzz_bytes_t *b, cam_param_id_t id)
{
    const cam_param_info_t *info = cam_param_info(id);
    return (fuzz_u8(b) & 1u) == 0u ? info->def : within(b, info->min, info->max);
}

/// @return parameters with those of the loop drawn, in the order of the list
static cam_params_t drawn(fuzz_bytes_t *b)
{
    cam_params_t params = cam_param_defaults();
    params.u_scale_latency_ns = within(b, 0, 200000);
    for (uint32_t id = cam_param_servo_mass_g; id <= (uint32_t)cam_param_servo_thermal_ms; id++) {
        const int32_t value = parameter(b, (cam_param_id_t)id);
        FUZZ_EXPECT(cam_param_set(&params, (cam_param_id_t)id, value) == cam_ok, "%u is refused",
                    (unsigned)id);
    }
    return params;
}

static void expect_range(const char *name, int64_t value, int64_t least, int64_t most)
{
    FUZZ_EXPECT(least <= value && value <= most, "%s is %lld", name, (long long)value);
}

static void judge_coefficients(const cam_servo_config_t *c)
{
    const int64_t one_q30 = INT64_C(1) << 30;
    expect_range("kp", c->kp_q18, 0, cam_servo_most_gain);
    expect_range("kd", c->kd_q18, 0, cam_servo_most_gain);
    expect_range("ki", c->ki_q32, 0, cam_servo_most_gain);
    expect_range("pole", c->pole_q18, 0, 1 << 18);
    expect_range("b0", c->notch.b0_q30, 0, one_q30);
    expect_range("b1", c->notch.b1_q30, -2 * one_q30, 0);
    expect_range("b2", c->notch.b2_q30, -one_q30, one_q30);
    expect_range("-a2", c->notch.minus_a2_q30, -one_q30, one_q30);
    expect_range("mass", c->mass_q14, 0, cam_servo_most_gain);
    expect_range("drag", c->drag_q14, 0, cam_servo_most_gain);
    expect_range("stiffness", c->stiffness_q18, 0, cam_servo_most_gain);
    expect_range("limit", c->limit_q6, 0, cam_servo_most_q6);
    expect_range("rate", c->rate_q6, 0, 1 << 29);
    expect_range("overload", c->limit_q6, 0, (int64_t)c->continuous_q6 * cam_servo_most_overload);
    expect_range("cooling", c->cooling_q32, 0, INT64_C(1) << 31);
    expect_range("steps", c->ahead.steps_q16, -(16 << 16), 0);
}

static void step(cam_servo_t *s, const cam_servo_config_t *c, fuzz_bytes_t *b)
{
    const int32_t before_q6 = s->force_q6;
    const uint8_t what = fuzz_u8(b);
    const cam_servo_input_t in = {.set_q6 = fuzz_i32(b),
                                  .vel_q10 = fuzz_i32(b),
                                  .acc_q10 = fuzz_i32(b) >> 4,
                                  .actual_q6 = fuzz_i32(b),
                                  .push_q6 = within(b, -cam_servo_most_q6, cam_servo_most_q6)};
    if (what == 0u) {
        cam_servo_rest_isr(s, c);
        FUZZ_EXPECT(s->force_q6 == 0, "at rest: %d", (int)s->force_q6);
        return;
    }
    if (what == 1u) {
        cam_servo_start_isr(s, c, &in);
    }
    const int32_t from_q6 = what == 1u ? 0 : before_q6;
    s->most_q6 = what == 2u ? within(b, 0, cam_servo_most_q6) : s->most_q6;
    const int32_t force_q6 = cam_servo_step_isr(s, c, &in);
    const int64_t change_q6 = (int64_t)force_q6 - from_q6;
    fuzz_note(force_q6);
    fuzz_note(s->heat_q54);
    expect_range("force", force_q6, -(int64_t)c->limit_q6, c->limit_q6);
    expect_range("change of the force", change_q6, -(int64_t)c->rate_q6, c->rate_q6);
    FUZZ_EXPECT(force_q6 == s->force_q6, "%d is kept as %d", (int)force_q6, (int)s->force_q6);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes_t b = {.at = data, .n = size};
    const int32_t step_hz = within(&b, 500, 200000);
    const cam_params_t params = drawn(&b);
    cam_servo_config_t config;
    const cam_param_id_t refused = cam_servo_design(&params, step_hz, &config);
    fuzz_note(refused);
    if (refused != cam_n_params) {
        return 0;
    }
    fuzz_note_words(&config, sizeof config);
    judge_coefficients(&config);
    cam_servo_t servo = {0};
    cam_servo_start_isr(&servo, &config, &(cam_servo_input_t){0});
    for (uint32_t i = 0; i < (uint32_t)most_steps && b.n > 0u; i++) {
        step(&servo, &config, &b);
    }
    return 0;
}
