// SPDX-License-Identifier: Apache-2.0
/// budget_trace: where a debugger stops that wants to see one call, instruction by instruction.
#ifndef BUDGET_TRACE_H
#define BUDGET_TRACE_H

#include <stdint.h> // uint32_t

/// Any function; the debugger only needs its address.
typedef void budget_traced_fn(void);

/// Nothing happens here; the next call of a function is the one to look at.
/// @param name            of what is shown, up to 31 characters
/// @param n_instructions  that were counted, the call itself perhaps among them
static __attribute__((noipa)) void budget_trace(const char *name, uint32_t n_instructions,
                                                budget_traced_fn *next)
{
    (void)name;
    (void)n_instructions;
    (void)next;
}

#endif
