// SPDX-License-Identifier: Apache-2.0
/// flips_inner: what the parts of the rig share.
#ifndef FLIPS_INNER_H
#define FLIPS_INNER_H

#include "flips_rig.h"

/// Registers of an APB timer of the board.
typedef struct {
    uint32_t control, value, reload, interrupt; ///< writing 1 to interrupt clears it
} flips_timer_t;

#define TICKER (*(volatile flips_timer_t *)0x40000000u)
#define STRIKER (*(volatile flips_timer_t *)0x40001000u)
enum { timer_on = 1u << 0, timer_interrupts = 1u << 3 };

/// Registers that a checkpoint keeps: r4 .. r11, sp, lr, s16 .. s31.
typedef struct {
    uint32_t core[10];
    uint32_t fpu[16];
} flips_context_t;

enum { flips_max_strikes = 16384, flips_stack_bytes = 8192 };

/// The rig's memory, at the begin of its part of the PSRAM.
typedef struct {
    uint32_t magic;
    int32_t file; ///< of the results
    uint32_t n_strikes;
    uint32_t next; ///< strike that runs
    uint32_t tick; ///< ticks since the checkpoint
    uint32_t idle_count, idle_tick;
    uint32_t clock[flips_n_checkpoints], timer[flips_n_checkpoints];
    uint32_t n_golden[flips_n_checkpoints];
    uint32_t n_taken; ///< checkpoints
    uint32_t n_cut;   ///< ticks since start
    bool is_running;  ///< a run, not the cut in which checkpoints are taken
    bool is_armed;    ///< the striker waits for its place
    bool is_watching; ///< the striker is the watchdog
    flips_result_t result;
    uint32_t trampoline_at;
    flips_context_t context[flips_n_checkpoints];
    flips_strike_t strike[flips_max_strikes];
    flips_tick_t trace[flips_most + 1];
    flips_tick_t golden[flips_n_checkpoints][flips_most + 1];
} flips_memory_t;

#define RIG ((flips_memory_t *)0x60100000u)
#define RIG_SNAPSHOT(i) ((uint32_t *)(0x60400000u + 0x180000u * (i)))
#define RIG_STACK_TOP 0x60FF0000u
#define RIG_TRAMPOLINE ((uint32_t *)0x60FF8000u)
#define RIG_VECTORS ((uint32_t *)0x60FF9000u)
enum { flips_magic = 0x51195u };

/// The time of the port.
extern volatile struct flips_idle {
    uint32_t count; ///< rests of the main loop
    uint32_t at;    ///< [counts] of TIMER0 at the last one
} flips_idle;

/// Set the timers going at the place in their periods where a checkpoint was taken.
void flips_time_restore(uint32_t clock, uint32_t timer);
uint32_t flips_time_clock(void);

/// Switch the protection unit, which a write into the code needs off.
void flips_protect(bool is_on);

/// Keep the registers. @return 0, and once more 1 when the checkpoint is restored
uint32_t flips_keep_registers(flips_context_t *context) __attribute__((returns_twice));

/// Go on where flips_keep_registers() was called.
_Noreturn void flips_take_registers(const flips_context_t *context);

/// Vectors of the image while the rig is in charge, and the protection unit's regions.
void flips_set_vectors(void);

/// Restore the checkpoint of the run; on the rig's own stack.
_Noreturn void flips_restore(void);

/// Arm the striker for the tick that begins, where it is due.
void flips_arm(void);

#endif
