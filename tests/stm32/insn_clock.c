// SPDX-License-Identifier: Apache-2.0
/// insn_clock: the emulator's clock. The CPU emulator calls the hook before every instruction; one
/// instruction is one cycle. In C because a hook in Python would be a hundred times slower.
#include <stdint.h> // uint64_t

/// Shared with bus.py (InsnClock), same order.
typedef struct {
    uint64_t now;      ///< [cycles] since power-on, sleep included
    uint64_t deadline; ///< [cycles] the instruction that would begin at or behind it does not run
    int (*stop)(void *engine);
} insn_clock_t;

void insn_clock_hook(void *engine, uint64_t address, uint32_t size, void *user);

void insn_clock_hook(void *engine, uint64_t address, uint32_t size, void *user)
{
    insn_clock_t *clock = user;
    (void)address;
    (void)size;
    if (clock->now >= clock->deadline) {
        (void)clock->stop(engine);
    } else {
        clock->now++;
    }
}
