// SPDX-License-Identifier: Apache-2.0
// The slow side reads while another core ticks, as on Linux: all fields of a status belong to the
// same tick, however often a reading falls into a tick. The preset host-tsan runs this under the
// sanitizer of threads.
#define OWN_SET_UP
#include "cam_config.h"
#include "rig_bench.h"
#include <pthread.h>

/// A fault comes in one tick of each period; it is the emergency stop and a drive in turn.
enum { period = 64, at_manual = 4, at_fault = 20, at_end = 24, at_reset = 48, n_periods = 15000 };
enum { pause = 400 }; ///< turns of an empty loop between two ticks

static uint32_t first_tick;
static uint32_t n_requests;
static _Atomic bool is_over;

void setUp(void)
{
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, 20000);
    fixture_rig_ticks(&rig, 100);
    n_requests = 1000;
    atomic_store(&is_over, false);
}

static void ask(cam_request_t request)
{
    atomic_store(&g_cam.request, ++n_requests << 8 | (uint32_t)request);
}

/// What happens in front of a tick of the script.
static void play_script(uint32_t n)
{
    const bool is_even = n / period % 2u == 0u;
    switch (n % period) {
    case at_manual:
        ask(cam_request_manual);
        break;
    case at_fault:
        hal_host_fault_estop(is_even);
        hal_host_fault_drive(!is_even);
        break;
    case at_end:
        hal_host_fault_estop(false);
        hal_host_fault_drive(false);
        break;
    case at_reset:
        ask(cam_request_reset);
        break;
    default:
        break;
    }
}

/// The core of the interrupt.
static void *tick(void *unused)
{
    for (uint32_t n = 0; n < (uint32_t)n_periods * period; n++) {
        play_script(n);
        hal_host_tick();
        for (volatile int i = 0; i < pause; i++) {
        }
    }
    atomic_store(&is_over, true);
    return unused;
}

static void expect_one_tick(const cam_status_t *s)
{
    const uint32_t n = s->tick - first_tick;
    const uint32_t at = n % period;
    const bool is_fault = at >= (uint32_t)at_fault && at < (uint32_t)at_reset;
    const uint32_t last = at >= (uint32_t)at_fault ? n / period : n / period - 1u;
    const uint32_t kind =
        last % 2u == 0u ? (uint32_t)CAM_FAULT_BIT(estop) : (uint32_t)CAM_FAULT_BIT(drive);
    TEST_ASSERT_EQUAL_HEX32(is_fault ? kind : 0u, s->faults);
    if (n >= (uint32_t)period) {
        TEST_ASSERT_EQUAL_HEX32(kind, s->first_fault);
    }
}

static void test_status_belongs_to_one_tick(void)
{
    pthread_t core;
    uint32_t n_read = 0;
    uint32_t next = 0;
    first_tick = fixture_rig_status(&rig).tick + 1u;
    TEST_ASSERT_EQUAL_INT(0, pthread_create(&core, NULL, tick, NULL));
    while (!atomic_load(&is_over)) {
        const cam_status_t status = cam_status_read(&g_cam);
        if (status.tick - first_tick < UINT32_MAX / 2u) {
            expect_one_tick(&status);
            n_read++;
        }
        // Everything else that both cores touch: the trace without a gap, and configurations.
        for (cam_tick_record_t record; cam_trace_pop(&g_cam.trace, &record);) {
            const bool has_gap = g_cam.trace.n_missed > 0u;
            TEST_ASSERT_TRUE(has_gap || next == 0u || record.tick == next);
            next = record.tick + 1u;
        }
        if (cam_config_copy(&g_cam.config) != NULL) {
            cam_config_offer(&g_cam.config);
        }
    }
    TEST_ASSERT_EQUAL_INT(0, pthread_join(core, NULL));
    TEST_ASSERT_GREATER_THAN_UINT32(100, n_read);
}
