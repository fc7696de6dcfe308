// SPDX-License-Identifier: Apache-2.0
// Plays the machine for firmware/main.c as it is: does it start, tick and stay safe?
#include "image_machine.h"
#include "hal/hal.h"
#include "mps2_machine.h"
#include "mps2_semihost.h"

enum { last_period = 2000, x_nm = 49000000, z_nm = -2000000 };

static void ends(const char *why, int status)
{
    hal_text(why);
    mps2_exit(status);
}

/// In state off: drives without enable, spindle at rest, set-points where the axes are.
static bool is_safe(void)
{
    bool is_here = true;
    for (int i = 0; i < hal_n_axes; i++) {
        is_here = is_here && mps2_machine.out.axis[i].pos_nm == mps2_machine.in.axis_nm[i];
    }
    return is_here && mps2_machine.out.outputs == 0u && mps2_machine.out.spindle_mrpm == 0;
}

void mps2_machine_step_isr(void)
{
    if (image_machine.n_periods == 0u) { // the axes are moved by hand
        image_machine_init(x_nm, z_nm);
    } else if (!is_safe()) {
        ends("failed: not safe while off", 1);
    } else if (image_machine.n_periods == last_period) {
        ends("2000 ticks, safe in all of them", 0);
    }
    image_machine_step_isr();
}
