// SPDX-License-Identifier: Apache-2.0
/// insn_clock: the emulator's clock. The CPU emulator calls the hook before every instruction; one
/// instruction is one cycle. In C because a hook in Python would be a hundred times slower.
#include <stdint.h> // uint64_t

enum { n_barriers = 8192 };

/// Shared with bus.py (InsnClock), same order.
typedef struct {
    uint64_t now;      ///< [cycles] since power-on, sleep included
    uint64_t deadline; ///< [cycles] the instruction that would begin at or after it does not run
    int (*stop)(void *engine);
    uint64_t barrier_at;           ///< [cycles] when the last instruction DSB began
    uint32_t barriers[n_barriers]; ///< addresses of all of them, each at its place
} insn_clock_t;

void insn_clock_hook(void *engine, uint64_t address, uint32_t size, void *user);

void insn_clock_hook(void *engine, uint64_t address, uint32_t size, void *user)
{
    insn_clock_t *clock = user;
    (void)size;
    if (clock->now >= clock->deadline) {
        (void)clock->stop(engine);
    } else {
        clock->now++;
        if (clock->barriers[address >> 1 & (n_barriers - 1)] == address) {
            clock->barrier_at = clock->now;
        }
    }
}
