// SPDX-License-Identifier: Apache-2.0
/// flips_rig: what strikes the firmware, watches what the axes are told, and begins again.
///
/// All of it lies beside the firmware in one image, but its data lies in the PSRAM, away from
/// everything that the firmware knows. A run is
///
///     checkpoint -> restored -> ticks, one bit flips in one of them -> horizon or end -> reset
///
/// Checkpoints are taken once, in the tick's interrupt of a cut: all of the RAM, the stack and the
/// registers. What is to be struck is read from a file, what happened is written to another one
/// (flips_image.py).
#ifndef FLIPS_RIG_H
#define FLIPS_RIG_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

enum { flips_scale = 16 };                        ///< virtual time is this much slower than real
enum { flips_period = 1250 * flips_scale };       ///< [counts] of TIMER0 in a tick
enum { flips_n_checkpoints = 6 };                 ///< see flips_rig.c
enum { flips_horizon = 1200, flips_most = 4000 }; ///< [ticks] of a run without and with a fault
enum { flips_watchdog_ticks = 4 };                ///< the tick may stay away for less than this

/// What is struck.
typedef enum {
    flips_nothing,  ///< the run to compare with
    flips_register, ///< `place` is its number: 0..12, 13 sp, 14 lr, 15 pc, 16 xPSR
    flips_memory,   ///< `place` is the address of a byte
    flips_stack,    ///< `place` is the share of the live stack, of 2^32
} flips_kind_t;

/// One strike, as the file holds it.
typedef struct {
    uint32_t id;
    uint32_t checkpoint;
    uint32_t tick; ///< ticks behind the checkpoint, from 1
    uint32_t at;   ///< [counts] of TIMER0 since the tick's begin
    uint32_t kind; ///< flips_kind_t
    uint32_t place;
    uint32_t bit;
    uint32_t reserved;
} flips_strike_t;

/// How a run ended.
typedef enum {
    flips_ran,       ///< to the horizon, or until a fault's retract was over
    flips_exception, ///< HardFault or another exception
    flips_watchdog,  ///< no tick for flips_watchdog_ticks
    flips_halt,      ///< hal_halt()
} flips_end_t;

/// One tick of the trace.
typedef struct {
    int32_t nm[3]; ///< told to U, X, Z
    int32_t spindle_mrpm;
    uint32_t outputs;
    uint32_t faults;           ///< the guard's, to explain
    uint32_t begin, end, idle; ///< [counts] of the interrupt in this tick, of the main loop's
                               ///< rest before it (0: it did not rest)
} flips_tick_t;

/// What is written of a run, followed by `n_told` ticks of the trace from `first` on.
typedef struct {
    uint32_t id;
    uint32_t end;       ///< flips_end_t
    uint32_t detail;    ///< number of the exception
    uint32_t pc;        ///< where the bit flipped
    uint32_t address;   ///< what was struck, for memory and stack
    uint32_t is_struck; ///< 0: the run ended before
    uint32_t n_ticks;   ///< ticks of the run
    uint32_t idle_tick; ///< last tick before which the main loop rested
    uint32_t digest;    ///< of the controller's state at the end
    uint32_t n_fed;     ///< reserved for the port's own supervision
    uint32_t first;     ///< first tick of the trace that differs, n_ticks where none does
    uint32_t n_told;
} flips_result_t;

/// Main: the first start runs the cut until all checkpoints are taken, all later ones restore one.
/// Does not return when there is something to restore.
void flips_begin(void);

/// In the tick, around cam_isr(). Context: the tick's interrupt.
void flips_before_isr(void);
void flips_after_isr(void);

/// Strike, or bark when the tick stays away. Context: the striker's interrupt.
/// @param frame  what the exception has stacked
/// @param saved  r4 .. r11
void flips_strike_isr(uint32_t *frame, uint32_t *saved, uint32_t exc_return);

/// An exception ended the run. @param number  of the exception
_Noreturn void flips_caught(uint32_t number);

/// hal_halt() ended the run.
_Noreturn void flips_halted(int status);

/// End of a run: tell, then begin the next one by a reset.
_Noreturn void flips_finish(flips_end_t end, uint32_t detail);

#endif
