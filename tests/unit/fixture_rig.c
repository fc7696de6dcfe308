// SPDX-License-Identifier: Apache-2.0
#include "fixture_rig.h"
#include "hal_host.h" // hal_host
#include <math.h>     // fabs
#include <string.h>   // memset

void fixture_rig_init(fixture_rig_t *rig, const fixture_part_t *part, uint32_t tick_hz)
{
    memset(rig, 0, sizeof *rig);
    rig->ramp_rpm = 2500.0 * 10.0 / tick_hz; // 2500 r/min in 0.1 s
    hal_host_reset(tick_hz);
    cam_machine_init(&rig->machine, &g_cam, tick_hz, hal_clock_hz());
    fixture_encoder_init(&rig->encoder, rig->machine.params.counts_per_turn, 1, 1000u, 1234);
    fixture_rig_tick(rig);
    (void)fixture_rig_set(rig, cam_param_lead_ns, (int32_t)(1000000000u / tick_hz));
    fixture_image_make(&rig->image, part);
    if (cam_machine_select_table(&rig->machine, rig->image.bytes, rig->image.size) == cam_ok) {
        fixture_rig_tick(rig);
    }
}

static void turn_spindle(fixture_rig_t *rig)
{
    const double goal = hal_host.out.spindle_mrpm / 1000.0;
    const double left = goal - rig->rpm;
    if (!rig->is_spindle_held) {
        rig->rpm += fabs(left) <= rig->ramp_rpm ? left : left > 0 ? rig->ramp_rpm : -rig->ramp_rpm;
    }
    const double late = (double)hal_host.late_clocks / hal_host_clock_hz; // it turns on meanwhile
    const double period = 1.0 / hal_host.tick_hz + late;
    hal_host.in.encoder = fixture_encoder_move(&rig->encoder, rig->rpm / 60.0 * period);
}

/// The drive goes on from set-point to set-point, which may wrap.
static void move_swing(fixture_rig_t *rig)
{
    const hal_swing_t *set = &hal_host.out.swing;
    const bool is_new = rig->n_swing != hal_host.out.n_swing;
    const int32_t from_q32 = is_new ? set->pos_q32 : hal_host.in.swing_q32;
    rig->n_swing = hal_host.out.n_swing;
    if (!rig->is_swing_held) {
        hal_host.in.swing_q32 = (int32_t)((uint32_t)from_q32 + (uint32_t)set->vel_q32);
    }
}

static void move_axes(fixture_rig_t *rig)
{
    if ((hal_host.out.outputs & hal_out_enable) == 0u) {
        return;
    }
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        if (i != hal_axis_z || !rig->is_z_held) {
            hal_host.in.axis_nm[i] = hal_host.out.axis[i].pos_nm;
        }
    }
    hal_host.in.axis_nm[hal_axis_u] += rig->u_error_nm;
    move_swing(rig);
}

void fixture_rig_tick(fixture_rig_t *rig)
{
    turn_spindle(rig);
    move_axes(rig);
    if (rig->isr != NULL) {
        hal_host_advance();
        rig->isr();
    } else {
        hal_host_tick();
    }
    while (cam_trace_pop(&g_cam.trace, &rig->last)) {
        if (rig->n_log < rig->log_capacity) {
            rig->log[rig->n_log++] = rig->last;
        }
    }
}

void fixture_rig_ticks(fixture_rig_t *rig, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        fixture_rig_tick(rig);
    }
}

uint32_t fixture_rig_until(fixture_rig_t *rig, cam_state_t state, uint32_t n_max)
{
    uint32_t n = 0;
    while (n < n_max && fixture_rig_status(rig).state != state) {
        fixture_rig_tick(rig);
        n++;
    }
    return n;
}

static bool reaches(fixture_rig_t *rig, cam_state_t state)
{
    enum { patience = 60000 };
    return fixture_rig_until(rig, state, patience) < patience;
}

bool fixture_rig_bring(fixture_rig_t *rig, cam_state_t state)
{
    if (state == cam_state_off) {
        return fixture_rig_status(rig).state == cam_state_off;
    }
    if (cam_machine_enable(&rig->machine) != cam_ok || !reaches(rig, cam_state_homing)) {
        return false;
    }
    if (state == cam_state_homing) {
        return true;
    }
    if (!reaches(rig, cam_state_ready)) {
        return false;
    }
    fixture_rig_ticks(rig, 2400); // the spindle runs up
    if (state == cam_state_ready) {
        return fixture_rig_status(rig).state == cam_state_ready;
    }
    return cam_machine_start(&rig->machine) == cam_ok && reaches(rig, state);
}

cam_err_t fixture_rig_set(fixture_rig_t *rig, cam_param_id_t id, int32_t value)
{
    const cam_err_t err = cam_machine_set_param(&rig->machine, id, value);
    fixture_rig_tick(rig);
    return err;
}

cam_status_t fixture_rig_status(const fixture_rig_t *rig)
{
    return cam_machine_status(&rig->machine);
}
