// SPDX-License-Identifier: Apache-2.0
// The firmware as an image, ticked by the board's timer: home, cut a short skirt, be ready again.
// Exit status 0: done as it should be; 1: not, with the reason. With IMAGE_U_STUCK the machine
// blocks U in the cut, so that the image must fail.
#include "cam_machine.h"
#include "cam_tick.h"
#include "fixture_image.h"
#include "hal/hal.h"
#include "image_machine.h"
#include "mps2_machine.h"
#include <stdio.h> // printf

#ifndef IMAGE_U_STUCK
#define IMAGE_U_STUCK false
#endif

enum { max_periods = 60000, u_stroke_nm = 300000 };

static fixture_image_t image;
static cam_machine_t machine;
static volatile uint32_t in_cut_periods;
static volatile int32_t u_low_nm = INT32_MAX, u_high_nm = INT32_MIN;

void mps2_machine_step_isr(void)
{
    if ((mps2_machine.out.outputs & hal_out_in_cut) != 0u) {
        const int32_t u_nm = mps2_machine.out.axis[hal_axis_u].pos_nm;
        u_low_nm = u_nm < u_low_nm ? u_nm : u_low_nm;
        u_high_nm = u_nm > u_high_nm ? u_nm : u_high_nm;
        in_cut_periods++;
        image_machine.is_u_stuck = IMAGE_U_STUCK;
    }
    image_machine_step_isr();
}

static bool fails(const char *what)
{
    const cam_status_t status = cam_machine_status(&machine);
    printf("failed: %s; state %s, faults 0x%04lx, tick %lu\n", what, cam_state_name(status.state),
           (unsigned long)status.faults, (unsigned long)status.tick);
    return false;
}

/// The background loop of a machine, until something happens.
static bool wait_for(cam_state_t state)
{
    while (image_machine.n_periods < max_periods) {
        const cam_status_t status = cam_machine_status(&machine);
        if (status.state == state) {
            return true;
        }
        if (status.state == cam_state_fault) {
            return fails("a fault");
        }
        cam_machine_poll(&machine);
        hal_idle();
    }
    return fails("no end");
}

static bool set(cam_param_id_t id, int32_t value)
{
    hal_idle(); // the change before has been taken
    hal_idle();
    return cam_machine_set_param(&machine, id, value) == cam_ok || fails(cam_param_info(id)->name);
}

static bool prepare(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    image_machine_init(part.x_offset_nm + 3000000, part.z_first_nm - 2000000);
    if (hal_init() != 0) {
        return fails("hal_init()");
    }
    cam_machine_init(&machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    hal_tick_start();
    hal_idle();
    // The set-point of a tick is reached in the next: one period of dead time.
    if (!set(cam_param_counts_per_turn, image_counts_per_turn) ||
        !set(cam_param_lead_ns, (int32_t)(1000000000u / hal_tick_hz()))) {
        return false;
    }
    hal_idle();
    hal_idle();
    const cam_err_t err = cam_machine_select_table(&machine, image.bytes, image.size);
    hal_idle();
    hal_idle();
    return err == cam_ok || fails(cam_err_text(err));
}

static bool cut(void)
{
    if (cam_machine_enable(&machine) != cam_ok || !wait_for(cam_state_homing) ||
        !wait_for(cam_state_ready)) {
        return fails("not homed");
    }
    if (cam_machine_start(&machine) != cam_ok || !wait_for(cam_state_engaging) ||
        !wait_for(cam_state_cutting) || !wait_for(cam_state_disengaging) ||
        !wait_for(cam_state_ready)) {
        return fails("not cut");
    }
    return true;
}

/// Ten turns at 2500 r/min and the easing of the feed: 0.29 s of cutting; an oval of 0.2 to 0.3 mm
/// moves U by half of that.
static bool is_cut_right(void)
{
    const uint32_t n_periods = image_machine.n_periods; // the interrupt goes on meanwhile
    const cam_status_t status = cam_machine_status(&machine);
    const uint32_t cut_ms = in_cut_periods * 1000u / hal_tick_hz();
    const int32_t stroke_nm = u_high_nm - u_low_nm;
    printf("%lu periods, %lu ms of cutting, U moved %ld nm, tick of at most %lu clocks\n",
           (unsigned long)n_periods, (unsigned long)cut_ms, (long)stroke_nm,
           (unsigned long)hal_load().max_cycles);
    if (status.tick - n_periods + 1u > 2u || status.n_late != 0u) {
        return fails("ticks were lost or late");
    }
    if (cut_ms < 280u || cut_ms > 300u) {
        return fails("the cut took another time");
    }
    if (stroke_nm < u_stroke_nm / 2 - 10000 || stroke_nm > u_stroke_nm / 2 + 10000) {
        return fails("U moved otherwise");
    }
    return mps2_machine.in.axis_nm[hal_axis_z] == machine.table.z_last_nm ||
           fails("Z is not at the last height");
}

int main(void)
{
    return prepare() && cut() && is_cut_right() ? 0 : 1;
}
