// SPDX-License-Identifier: Apache-2.0
// The time part of the port; the machine part is hal/mps2/mps2_port.c.
#include "pil_time.h"
#include "hal/hal.h"

pil_time_t pil_time;

uint32_t hal_tick_hz(void)
{
    return pil_time.tick_hz;
}

uint32_t hal_clock_hz(void)
{
    return pil_time.clock_hz;
}

uint32_t hal_clock_isr(void)
{
    return pil_time.clock;
}

void hal_tick_start(void) {}

void hal_idle(void) {}

hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}
