// SPDX-License-Identifier: Apache-2.0
/// acknowledge_bench: a controller whose port has the button at the machine, and that button.
#ifndef ACKNOWLEDGE_BENCH_H
#define ACKNOWLEDGE_BENCH_H

#include "cam_machine_hand.h" // cam_machine_manual
#include "fixture_rig.h"      // fixture_rig_t
#include "hal_host.h"         // hal_host_press
#include "unity.h"

static fixture_rig_t f;
static fixture_part_t part;

/// [ticks] of a time.
static inline uint32_t ms(uint32_t n)
{
    return n * (hal_host.tick_hz / 1000u);
}

/// Power on a controller with what its port has by now, and give it the table.
static inline void power_on(void)
{
    cam_machine_init(&f.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    fixture_rig_tick(&f);
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_select_table(&f.machine, f.image.bytes, f.image.size));
}

static inline void begin(uint32_t tick_hz)
{
    part = fixture_part_short();
    fixture_rig_init(&f, &part, tick_hz);
    // Again, on a machine that has the button.
    hal_host.slow.people = (hal_operator_t){.has_acknowledge = true};
    power_on();
    fixture_rig_ticks(&f, ms(100));
}

/// Minutes pass sooner at a slower tick; test_a_press_is_good_for_a_minute has the usual one.
static inline void begin_slowly(void)
{
    begin(2000);
}

/// The level of the button for some time.
static inline void button(bool is_pressed, uint32_t ticks)
{
    hal_host_press(is_pressed);
    fixture_rig_ticks(&f, ticks);
}

static inline void press(void)
{
    button(true, ms(100));
    button(false, ms(100));
}

/// Post a request as the slow side does, but without its judgement.
static inline void post(cam_request_t request)
{
    f.machine.n_requests++;
    atomic_store(&g_cam.request, f.machine.n_requests << 8 | (uint32_t)request);
}

static inline cam_err_t enable(void)
{
    const cam_err_t err = cam_machine_enable(&f.machine);
    fixture_rig_ticks(&f, 2);
    return err;
}

static inline cam_state_t state(void)
{
    return fixture_rig_state();
}

static inline void expect_refused(void)
{
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, enable());
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, cam_machine_manual(&f.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_acknowledge, cam_machine_home(&f.machine));
    // The interrupt refuses by itself, whatever the slow side would post.
    const cam_request_t requests[] = {cam_request_enable, cam_request_manual};
    for (int i = 0; i < 2; i++) {
        post(requests[i]);
        fixture_rig_ticks(&f, 10);
        TEST_ASSERT_EQUAL_INT(cam_state_off, state());
        TEST_ASSERT_EQUAL_UINT32(0, hal_host.out.outputs & hal_out_enable);
    }
}

static inline void expect_enabled(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, enable());
    TEST_ASSERT_EQUAL_INT(cam_state_homing, state());
}

static inline void disable(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&f.machine));
    fixture_rig_ticks(&f, ms(100));
    TEST_ASSERT_EQUAL_INT(cam_state_off, state());
}

/// Bring the machine to ready, and let the emergency stop end that.
static inline void stop_in_ready(void)
{
    press();
    expect_enabled();
    (void)fixture_rig_until(&f, cam_state_ready, 60000);
    TEST_ASSERT_EQUAL_INT(cam_state_ready, state());
    hal_host_fault_estop(true);
    fixture_rig_ticks(&f, ms(200));
    TEST_ASSERT_EQUAL_INT(cam_state_fault, state());
}

#endif
