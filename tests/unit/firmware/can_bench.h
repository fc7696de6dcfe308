// SPDX-License-Identifier: Apache-2.0
/// can_bench: a whole controller on a bus, as rig_bench.h with the short skirt at 20 kHz, started
/// anew for each test. Each program that includes it has one bench.
#ifndef CAN_BENCH_H
#define CAN_BENCH_H

#include "fixture_can.h" // fixture_can_t

static fixture_can_t f;

/// Called by Unity before each test.
void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
}

/// Called by Unity after each test.
void tearDown(void) {}

#endif
