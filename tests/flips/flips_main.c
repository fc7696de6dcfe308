// SPDX-License-Identifier: Apache-2.0
// A cut of a short skirt on the emulated core, as tests/image cuts it, for the rig to strike.
#include "cam_machine.h"
#include "fixture_image.h"
#include "flips_inner.h"
#include "hal/hal.h"
#include "image_machine.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"
#include <stdio.h> // snprintf

enum { max_periods = 40000 };

static fixture_image_t image;
cam_machine_t flips_machine;

static void fail(const char *what)
{
    const cam_status_t status = cam_machine_status(&flips_machine);
    printf("failed: %s; state %s, faults 0x%04lx\n", what, cam_state_name(status.state),
           (unsigned long)status.faults);
    mps2_exit(1);
}

static void must(cam_err_t err)
{
    if (err != cam_ok) {
        fail(cam_err_text(err));
    }
}

static void rest(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_machine_poll(&flips_machine);
        hal_idle();
    }
}

static void set(cam_param_id_t id, int32_t value)
{
    must(cam_machine_set_param(&flips_machine, id, value));
    rest(3);
}

static void wait_for(cam_state_t state)
{
    while (cam_machine_status(&flips_machine).state != state) {
        if (image_machine.n_periods > max_periods ||
            cam_machine_status(&flips_machine).state == cam_state_fault) {
            fail(cam_state_name(state));
        }
        rest(1);
    }
}

static void tell(int32_t file, const char *name, const void *at, size_t n)
{
    char line[96];
    const int length = snprintf(line, sizeof line, "%s %lu %lu\n", name,
                                (unsigned long)(uintptr_t)at, (unsigned long)n);
    (void)mps2_file_write(file, line, (size_t)length);
}

#define TELL(name, object) tell(file, name, &(object), sizeof(object))

/// Where the state lies, and the limits that a judge needs.
static void tell_map(void)
{
    const int32_t file = mps2_file_open("flips.map", true);
    const cam_config_t *cfg = g_cam.config.in_use;
    TELL("state.spindle", g_cam.spindle);
    TELL("state.motion", g_cam.motion);
    TELL("state.play", g_cam.play);
    TELL("state.guard", g_cam.guard);
    TELL("state.tell", g_cam.command);
    TELL("state.watch", g_cam.watch);
    TELL("state.plan", g_cam.plan);
    TELL("state.hand", g_cam.jog);
    TELL("state.switches", g_cam.switches);
    TELL("state.gather", g_cam.bins);
    tell(file, "state.words", &g_cam.until_plan,
         (size_t)((const char *)&g_cam.bins - (const char *)&g_cam.until_plan));
    TELL("state.acknowledge", g_cam.acknowledge);
    TELL("state.request", g_cam.request);
    tell(file, "state.config", &g_cam.config, offsetof(cam_config_bank_t, half));
    tell(file, "state.trace", &g_cam.trace, sizeof g_cam.trace);
    TELL("config.spindle", cfg->spindle);
    TELL("config.play", cfg->play);
    TELL("config.guard", cfg->guard);
    TELL("config.tell", cfg->command);
    TELL("config.switches", cfg->switches);
    TELL("config.table", cfg->table);
    tell(file, "config.words", &cfg->trace_room,
         (size_t)((const char *)&cfg->learned - (const char *)&cfg->trace_room));
    TELL("config.learned", cfg->learned);
    TELL("slow.machine", flips_machine);
    tell(file, "table.image", image.bytes, image.size);
    const cam_params_t *p = &flips_machine.params;
    tell(file, "limit.tick_hz", 0, hal_tick_hz());
#define LIMIT(name) tell(file, "limit." #name, 0, (size_t)p->name)
    LIMIT(u_stroke_nm);
    LIMIT(u_speed_um_per_s);
    LIMIT(u_acceleration_mm_per_s2);
    LIMIT(x_speed_um_per_s);
    LIMIT(x_acceleration_mm_per_s2);
    LIMIT(z_speed_um_per_s);
    LIMIT(z_acceleration_mm_per_s2);
    LIMIT(x_clearance_nm);
}

static void prepare(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
    image_machine_init(part.x_offset_nm + 3000000, part.z_first_nm - 2000000);
    mps2_machine.slow.measures_u = true;
    (void)hal_init();
    cam_machine_init(&flips_machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    hal_tick_start();
    rest(3);
    // The set-point of a tick is reached in the next: one period of dead time.
    set(cam_param_counts_per_turn, image_counts_per_turn);
    set(cam_param_lead_ns, (int32_t)(1000000000u / hal_tick_hz()));
    set(cam_param_following_limit_nm, 0);
    must(cam_machine_select_table(&flips_machine, image.bytes, image.size));
    rest(3);
}

int main(void)
{
    flips_begin();
    prepare();
    must(cam_machine_enable(&flips_machine));
    wait_for(cam_state_ready);
    must(cam_machine_start(&flips_machine));
    wait_for(cam_state_engaging);
    tell_map();
    for (;;) {
        rest(1);
    }
}
