// SPDX-License-Identifier: Apache-2.0
/// lin_bus_bench: the Linux port's nodes on a bus without wires: frames come and go by calls. Each
/// program that includes it has one bench.
#ifndef LIN_BUS_BENCH_H
#define LIN_BUS_BENCH_H

#include "common_bytes.h" // common_put_i32
#include "lin_bus.h"      // lin_bus_t
#include "unity.h"        // TEST_ASSERT_TRUE
#include <stddef.h>       // NULL

static const int64_t ms = 1000000;

static lin_config_t config;
static lin_bus_t bus;
static lin_commands_t commands;
static hal_can_frame_t frames[lin_bus_max_frames];
static uint32_t n_frames;
static int64_t now;

/// Let one tick pass; its frames are in `frames`.
static inline void make(void)
{
    n_frames = lin_bus_make(&bus, &commands, now, frames);
    now += ms;
}

/// Begin: the port listens for 100 ms and then sends at least the SYNC.
static inline void begin(void)
{
    lin_bus_init(&bus, &config);
    for (int i = 0; i <= 101; i++) {
        make();
        TEST_ASSERT_TRUE((n_frames != 0u) == (i == 101));
    }
}

/// Begin with a configuration of five nodes at 1 kHz. To be called by setUp().
static inline void bench_begin(void)
{
    config = lin_config_defaults();
    config.thread.tick_hz = 1000;
    commands = (lin_commands_t){.outputs = 0};
    now = 1000 * ms;
    begin();
}

/// A frame arrives, its bytes given as two little-endian words.
static inline void hear(uint32_t id, uint32_t n, uint32_t low, uint32_t high)
{
    hal_can_frame_t frame = {.id = id, .n = n};
    common_put_i32(frame.data, (int32_t)low);
    common_put_i32(frame.data + 4, (int32_t)high);
    lin_bus_receive(&bus, &frame, now);
}

/// The heartbeat of a node in operation arrives.
static inline void beat(uint32_t node)
{
    hear(0x700 + node, 1, 5, 0);
}

/// Every node sends what is due, and the drives send this status word.
static inline void hear_all(uint32_t status)
{
    for (uint32_t node = 1; node <= 5u; node++) {
        beat(node);
    }
    hear(0x181, 4, (uint32_t)(now / 20000), 0); // 50 counts a tick
    for (uint32_t node = 2; node <= 5u; node++) {
        hear(0x180 + node, 6, status | node << 16, 0);
    }
}

/// @return the inputs after a judgement of all nodes
static inline uint32_t judge(void)
{
    lin_bus_judge(&bus, now);
    return bus.inputs;
}

/// @return the frame of the last tick with this id, NULL when there is none
static inline const hal_can_frame_t *find(uint32_t id)
{
    for (uint32_t i = 0; i < n_frames; i++) {
        if (frames[i].id == id) {
            return &frames[i];
        }
    }
    return NULL;
}

/// Bring all drives into operation, enabled.
static inline void enable(void)
{
    hear_all(0x237);
    commands.outputs = hal_out_enable;
    make();
    hear_all(0x237);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, judge());
}

#endif
