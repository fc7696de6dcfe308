// SPDX-License-Identifier: Apache-2.0
#include "stm_port.h"
#include "hal/hal.h"
#include "stm_memory.h" // stm_ecc_corrected

/// Written by the interrupt, read by the slow side, one word at a time.
static volatile struct {
    uint32_t n_ticks;
    uint32_t last_cycles, max_cycles;
    bool is_behind; ///< interrupt only: the last tick ended after the next one was due
} tick;

/// Faults are latched last, so that an overrun during the measurement is included.
void stm_tick_isr(void)
{
    const uint32_t begin = DWT_CYCCNT;
    stm_timers_tick_begin_isr();
    stm_watch_tick_isr(tick.is_behind);
    cam_isr();
    uint32_t faults = stm_timers_is_late_isr() ? stm_fault_late : 0u;
    faults |= stm_dac_send_isr() ? 0u : stm_fault_dac;
    stm_steps_send_isr();
    tick.n_ticks++;
    const uint32_t cycles = DWT_CYCCNT - begin;
    tick.last_cycles = cycles;
    if (cycles > tick.max_cycles) {
        tick.max_cycles = cycles;
    }
    tick.is_behind = stm_timers_is_overrun_isr();
    faults |= tick.is_behind ? stm_fault_overrun : 0u;
    stm_faults |= faults;
}

void stm_tick_init(void)
{
    DCB_DEMCR |= DCB_DEMCR_TRCENA;
    DWT_LAR = DWT_LAR_KEY;
    DWT_CYCCNT = 0;
    DWT_CTRL |= DWT_CTRL_CYCCNTENA;
}

uint32_t stm_tick_count(void)
{
    return tick.n_ticks;
}

hal_load_t hal_load(void)
{
    return (hal_load_t){.last_cycles = tick.last_cycles,
                        .max_cycles = tick.max_cycles,
                        .cycles_hz = stm_cpu_hz,
                        .n_corrected = stm_ecc_corrected()};
}
