// SPDX-License-Identifier: Apache-2.0
#include "flips_inner.h"

extern uint32_t mps2_stack_top[];

enum { in_lr = 5, in_pc = 6, in_xpsr = 7, extended = 1u << 4 };
enum { sp_number = 13, lr_number = 14 };

void flips_arm(void)
{
    const flips_strike_t *strike = &RIG->strike[RIG->next];
    if (strike->kind == flips_nothing || strike->tick != RIG->tick) {
        return;
    }
    const uint32_t now = flips_period - TICKER.value;
    const uint32_t left = strike->at > now + 8u ? strike->at - now : 8u;
    RIG->is_armed = true;
    STRIKER.control = 0;
    STRIKER.reload = flips_watchdog_ticks * flips_period;
    STRIKER.value = left;
    STRIKER.interrupt = 1;
    STRIKER.control = timer_on | timer_interrupts;
}

/// The stack pointer behind the return from the exception.
static uint32_t stack_pointer(const uint32_t *frame, uint32_t exc_return)
{
    const uint32_t size = (exc_return & extended) != 0u ? 0x20u : 0x68u;
    return (uint32_t)frame + size + (frame[in_xpsr] >> 9 & 1u) * 4u;
}

/// The stack pointer changes behind the return, by two instructions that need no register.
static void strike_stack_pointer(uint32_t *frame, uint32_t sp, uint32_t bit)
{
    RIG_TRAMPOLINE[0] = 0xD004F8DFu; // ldr sp, [pc, #4]
    RIG_TRAMPOLINE[1] = 0xF004F8DFu; // ldr pc, [pc, #4]
    RIG_TRAMPOLINE[2] = sp ^ 1u << bit;
    RIG_TRAMPOLINE[3] = frame[in_pc] | 1u;
    frame[in_pc] = (uint32_t)RIG_TRAMPOLINE;
}

static void strike_register(uint32_t *frame, uint32_t *saved, uint32_t sp, uint32_t number,
                            uint32_t bit)
{
    const uint32_t mask = 1u << bit;
    if (number < 4u) {
        frame[number] ^= mask;
    } else if (number < 12u) {
        saved[number - 4u] ^= mask;
    } else if (number == 12u) {
        frame[4] ^= mask;
    } else if (number == sp_number) {
        strike_stack_pointer(frame, sp, bit);
    } else { // lr, pc, xPSR follow one another
        frame[in_lr + number - lr_number] ^= mask;
    }
}

static uint32_t strike_byte(uint32_t address, uint32_t bit)
{
    flips_protect(false);
    *(volatile uint8_t *)address ^= (uint8_t)(1u << bit);
    flips_protect(true);
    return address;
}

static void strike_now(uint32_t *frame, uint32_t *saved, uint32_t exc_return)
{
    const flips_strike_t *strike = &RIG->strike[RIG->next];
    const uint32_t sp = stack_pointer(frame, exc_return);
    RIG->result.pc = frame[in_pc];
    RIG->result.is_struck = 1;
    if (strike->kind == flips_register) {
        strike_register(frame, saved, sp, strike->place, strike->bit);
    } else if (strike->kind == flips_memory) {
        RIG->result.address = strike_byte(strike->place, strike->bit);
    } else {
        const uint32_t live = (uint32_t)mps2_stack_top - sp;
        const uint32_t off = (uint32_t)((uint64_t)live * strike->place >> 32);
        RIG->result.address = strike_byte(sp + off, strike->bit);
    }
}

/// Bits 26:25 and 15:10 of xPSR: a conditional block is not broken up, the next instruction is
/// struck.
static bool is_conditional(const uint32_t *frame)
{
    return (frame[in_xpsr] & (3u << 25 | 0x3Fu << 10)) != 0u;
}

__attribute__((used)) void flips_strike_isr(uint32_t *frame, uint32_t *saved, uint32_t exc_return)
{
    STRIKER.interrupt = 1;
    if (RIG->is_watching) {
        flips_finish(flips_watchdog, 0);
    }
    if (RIG->strike[RIG->next].place == sp_number && is_conditional(frame)) {
        STRIKER.value = 4;
    } else {
        strike_now(frame, saved, exc_return);
        RIG->is_watching = true;
        STRIKER.value = flips_watchdog_ticks * flips_period;
    }
}
