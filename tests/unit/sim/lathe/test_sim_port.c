// SPDX-License-Identifier: Apache-2.0
#include "sim_port.h"
#include "sim_config.h"
#include "hal_host.h"  // hal_host
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"

static sim_lathe_config_t config;
static sim_port_t port;

void setUp(void)
{
    config = sim_config_defaults().lathe;
    config.spindle.ripple = 0.0;
}

static void test_port_says_what_the_machine_has(void)
{
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    TEST_ASSERT_FALSE(hal_has_edge_time());
    TEST_ASSERT_TRUE(hal_measures_u());
    TEST_ASSERT_EQUAL_UINT32(20000, hal_tick_hz());
    config.encoder.has_time_stamps = 1.0;
    config.tick_hz = 10000.0;
    config.drive[hal_axis_u].kind = sim_drive_force;
    config.drive[hal_axis_u].delay_us = 25.0;
    config.drive[hal_axis_u].force_quantum_n = 0.02;
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    TEST_ASSERT_TRUE(hal_has_edge_time());
    TEST_ASSERT_EQUAL_UINT32(10000, hal_tick_hz());
    TEST_ASSERT_EQUAL_UINT32(20000, hal_host.slow.force.quantum_un);
    TEST_ASSERT_EQUAL_UINT32(25000, hal_host.slow.force.latency_ns);
    hal_host.slow.force = (hal_force_t){.quantum_un = 0};
}

/// A tick of the firmware without the firmware; the next one may come late.
static void tick(uint32_t late_percent)
{
    sim_port_sense(&port);
    hal_host_advance();
    hal_host_fault_late(late_percent);
    port.late_s = (double)hal_host.late_clocks / hal_host_clock_hz;
    sim_port_advance(&port);
}

/// At a steady speed the stamps lie a whole number of counts apart, on the clock of the tick.
static void test_edge_clock_is_the_time_of_the_edge_on_the_clock_of_the_tick(void)
{
    const double rad_per_s = 100.0;
    const double clocks_per_count =
        hal_host_clock_hz * SIM_TWO_PI / (rad_per_s * config.encoder.counts_per_turn);
    config.encoder.has_time_stamps = 1.0;
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    hal_host.out.spindle_mrpm = (int32_t)sim_round(rad_per_s * 60000.0 / SIM_TWO_PI);
    for (int i = 0; i < 20000; i++) {
        tick(0);
    }
    hal_encoder_t first;
    hal_encoder_read_isr(&first);
    for (int i = 0; i < 4000; i++) {
        tick(i % 1000 == 500 ? 40 : 0); // a late tick is later on the clock, too
        hal_encoder_t now;
        hal_encoder_read_isr(&now);
        const uint32_t age = hal_clock_isr() - now.edge_clock;
        TEST_ASSERT_TRUE(age <= (uint32_t)clocks_per_count + 1u);
        const double counts = (int32_t)(now.counts - first.counts);
        const double clocks = (int32_t)(now.edge_clock - first.edge_clock);
        TEST_ASSERT_DOUBLE_WITHIN(2.0 + 1e-6 * clocks, counts * clocks_per_count, clocks);
    }
}

/// Early and late ticks and a fast clock: lathe and controller agree on what passes.
static void test_ticks_off_their_grid_take_their_time(void)
{
    sim_port_init(&port, &config, 50e6, 0.0, 1);
    hal_host.out.spindle_mrpm = 600000;
    for (int i = 0; i < 20000; i++) {
        tick(0);
    }
    const double turn = port.lathe.spindle.turn;
    const double from_s = port.time_s;
    const uint32_t clock = hal_host.clock;
    port.clock.jitter = 0.4;
    port.clock.drift = 1e-3;
    for (int i = 0; i < 1000; i++) {
        tick(0);
    }
    port.clock.jitter = 0.0;
    tick(0); // on the grid again
    hal_host_advance();
    const double gone_s = 1001 / config.tick_hz / 1.001;
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, gone_s, port.time_s - from_s);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 10.0 * gone_s, port.lathe.spindle.turn - turn);
    TEST_ASSERT_UINT32_WITHIN(1100, (uint32_t)(1002 / config.tick_hz * hal_host_clock_hz),
                              hal_host.clock - clock);
}
