// SPDX-License-Identifier: Apache-2.0
/// rig_bench: a whole controller on the ideal machine of fixture_rig, with the short skirt at 20
/// kHz, started anew for each test. Each program that includes it has one bench.
#ifndef RIG_BENCH_H
#define RIG_BENCH_H

#include "fixture_rig.h" // fixture_rig_t
#include "hal_host.h"    // hal_host_fault_estop
#include "unity.h"       // TEST_ASSERT_TRUE
#include <string.h>      // memcpy

static fixture_rig_t rig;
static fixture_part_t part;

/// Called by Unity before each test.
void setUp(void)
{
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, 20000);
}

/// Called by Unity after each test.
void tearDown(void) {}

/// Bring the controller from off into a state, without a fault.
static inline void bring(cam_state_t state)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, state));
    TEST_ASSERT_EQUAL_HEX32(0, fixture_rig_status(&rig).faults);
}

/// Flip a bit of any object.
static inline void flip(void *object, uint32_t bit)
{
    uint8_t *bytes = object;
    bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
}

/// A controller and the machine around it, to begin with more than once.
typedef struct {
    cam_t cam;
    fixture_rig_t rig;
    hal_host_t host;
} bench_t;

static inline void keep(bench_t *bench)
{
    memcpy(&bench->cam, &g_cam, sizeof g_cam);
    bench->rig = rig;
    bench->host = hal_host;
}

static inline void go_back(const bench_t *bench)
{
    memcpy(&g_cam, &bench->cam, sizeof g_cam);
    rig = bench->rig;
    hal_host = bench->host;
}

/// The controller in the cut, and the machine around it. It is brought there once and then put
/// back, for tests that do not depend on how it got there.
static inline void cut_anew(void)
{
    static bench_t bench;
    if (bench.rig.machine.core == NULL) {
        setUp();
        bring(cam_state_cutting);
        keep(&bench);
    }
    go_back(&bench);
}

#endif
