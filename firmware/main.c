// SPDX-License-Identifier: Apache-2.0
/// main: start-up and background loop of an image for a machine. The simulator has a loop of its
/// own.
#include "cam_machine.h"
#include "cam_remote.h"
#include "hal/hal.h"
#include "hal/version.h"

int main(void)
{
    static cam_machine_t machine;
    static cam_can_t remote;
    if (hal_init() != 0) {
        hal_halt("main: the port cannot be used");
    }
    hal_text("camturn " CAMTURN_VERSION);
    cam_machine_init(&machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    cam_machine_blackbox(&machine);
    cam_can_init(&remote, &machine); // selects the table; a bad one is reported, not fatal
    hal_tick_start();
    for (;;) {
        cam_machine_poll(&machine);
        cam_can_poll(&remote);
        hal_idle();
    }
}
