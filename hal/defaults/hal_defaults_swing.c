// SPDX-License-Identifier: Apache-2.0
/// hal_defaults_swing: the functions of hal.h for a port without a swing. They are not weak: the
/// linker takes all of them or none, so a port that defines some of them does not link.
#include "hal/hal.h"

bool hal_has_swing(void)
{
    return false;
}

int32_t hal_swing_read_q32_isr(void)
{
    return 0;
}

void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    (void)setpoint;
}
