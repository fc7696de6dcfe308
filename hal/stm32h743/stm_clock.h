// SPDX-License-Identifier: Apache-2.0
/// stm_clock: 480 MHz from the HSE, or from the HSI when the HSE does not start.
#ifndef STM_CLOCK_H
#define STM_CLOCK_H

/// Source of the clocks.
typedef enum {
    stm_clock_hse,  ///< crystal accuracy
    stm_clock_hsi,  ///< the same frequencies within about 1 %: for diagnosis, not for cutting
    stm_clock_fail, ///< supply or PLL not ready: still 64 MHz as after reset
} stm_clock_t;

/// [Hz] frequencies once stm_clock_init() has succeeded.
enum {
    stm_cpu_hz = 480000000,
    stm_timer_hz = 240000000, ///< of all timers
    stm_pll1q_hz = 80000000,  ///< kernel clock of SPI3 and FDCAN1
    stm_apb_hz = 120000000,
};

/// Raise supply and clocks from their state after reset, and let the clock security system
/// supervise the HSE.
/// @return source of the clocks
/// Context: slow side, once; blocks up to 0.2 s. Source: RM0433 6.6 (voltage scaling,
/// VOS0), 8.5 (PLLs, CSS), 4.3 (wait states).
stm_clock_t stm_clock_init(void);

#endif
