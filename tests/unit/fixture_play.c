// SPDX-License-Identifier: Apache-2.0
#include "fixture_play.h"
#include "cam/cam_build.h"     // cam_build_config
#include "fixture_reference.h" // fixture_reference_surface_at
#include <string.h>            // memset

enum { clock_hz = 200000000, patience = 1000000 };

void fixture_play_init(fixture_play_t *f, const fixture_part_t *part)
{
    memset(f, 0, sizeof *f);
    fixture_image_make(&f->image, part);
    if (cam_table_check(f->image.bytes, f->image.size, &f->table) != cam_ok) {
        return; // no table: enable is ignored, every test fails
    }
    f->tick_hz = FIXTURE_PLAY_HZ;
    f->params = cam_param_defaults();
    f->params.lead_ns = 0;
    f->angle =
        (cam_angle_t){.pos_q32 = 12345, .speed_q32 = FIXTURE_PLAY_SPEED_Q32, .is_synced = true};
    f->in.inputs = hal_in_drive_ready;
    fixture_play_configure(f);
}

void fixture_play_configure(fixture_play_t *f)
{
    const cam_err_t err =
        cam_build_config(&f->config, &f->params, &f->table, 3000000u, f->tick_hz, clock_hz);
    if (err != cam_ok) {
        f->config.play.table = NULL; // every test that goes on will fail
    }
}

void fixture_play_ask(fixture_play_t *f, cam_request_t request)
{
    f->in.request = ++f->n_asked << 8 | (uint32_t)request;
}

static void plan(fixture_play_t *f)
{
    f->until_plan--;
    if (f->until_plan <= 0) {
        f->until_plan = f->config.play.plan_ticks;
        const cam_tick_record_t r = {.in = f->in, .angle = f->angle, .want = f->want};
        cam_plan_isr(&f->plan, &f->config.play, &r, &f->motion);
    }
}

void fixture_play_settle(fixture_play_t *f, bool is_retracted)
{
    f->motion.state = cam_state_fault;
    f->motion.is_playing = false;
    f->motion.is_retracted = is_retracted;
}

void fixture_play_tick(fixture_play_t *f)
{
    f->angle.pos_q32 += f->angle.speed_q32;
    for (uint32_t i = 0; i < hal_n_axes && !f->is_axes_held; i++) {
        f->in.actual_nm[i] = (int32_t)(f->axis[i].pos_q10 / 1024);
    }
    memcpy(f->before, f->axis, sizeof f->before);
    cam_play_step_isr(&f->play, &f->config.play, &f->in, &f->angle, &f->motion, &f->want);
    memcpy(f->axis, f->motion.axis, sizeof f->axis);
    if (f->motion.is_playing) { // U is the guard's
        f->axis[hal_axis_u].pos_q10 = (int64_t)f->want.u_set_q6 * 16;
    }
    plan(f);
}

void fixture_play_ticks(fixture_play_t *f, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        fixture_play_tick(f);
    }
}

void fixture_play_do(fixture_play_t *f, cam_request_t request)
{
    fixture_play_ask(f, request);
    fixture_play_tick(f);
}

static bool reaches(fixture_play_t *f, cam_state_t state)
{
    for (uint32_t i = 0; i < patience && f->want.state != state; i++) {
        fixture_play_tick(f);
    }
    return f->want.state == state;
}

bool fixture_play_bring(fixture_play_t *f, cam_state_t state)
{
    fixture_play_tick(f);
    if (state == cam_state_off) {
        return f->want.state == cam_state_off;
    }
    fixture_play_do(f, cam_request_enable);
    if (state == cam_state_homing || f->want.state != cam_state_homing) {
        return f->want.state == cam_state_homing;
    }
    if (!reaches(f, cam_state_ready) || state == cam_state_ready) {
        return f->want.state == state;
    }
    fixture_play_do(f, cam_request_start);
    return reaches(f, state);
}

bool fixture_play_approach(fixture_play_t *f)
{
    for (uint32_t i = 0; i < patience && !f->motion.is_playing; i++) {
        fixture_play_tick(f);
    }
    return f->motion.is_playing;
}

double fixture_play_u_nm(const fixture_play_t *f, int64_t pos_q32, int32_t z_nm)
{
    const cam_channel_t *u = &f->table.u;
    const fixture_value_t v = fixture_reference_surface_at(u, (uint32_t)(uint64_t)pos_q32, z_nm);
    return (double)(v.y / (long double)(1u << u->frac_bits) + u->offset_nm);
}

double fixture_play_x_nm(const fixture_play_t *f, double z_nm)
{
    const cam_channel_t *x = &f->table.x;
    const double at = (z_nm - x->z_first_nm) / x->span_nm * (x->n_slices - 1u);
    const double in = at < 0.0 ? 0.0 : at > x->n_slices - 1u ? x->n_slices - 1u : at;
    const uint32_t i = in >= x->n_slices - 1u ? x->n_slices - 2u : (uint32_t)in;
    const fixture_value_t v = fixture_reference_profile(x, i, (long double)(in - i));
    return (double)(v.y / (long double)(1u << x->frac_bits) + x->offset_nm);
}

double fixture_play_smooth(double s)
{
    const double c = s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
    return c * c * c * (10.0 + c * (-15.0 + 6.0 * c));
}

double fixture_play_turns(int64_t pos_q32)
{
    return (double)pos_q32 / 4294967296.0;
}
