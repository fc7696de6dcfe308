// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // socketpair
#include "sim_live.h"
#include "unity.h"
#include <string.h>     // memset
#include <sys/socket.h> // socketpair
#include <unistd.h>     // close

enum { tick_hz = 20000 };

static int ends[2];
static sim_wire_t lathe, controller;
static common_error_t e;

/// Both ends of a wire whose greetings are exchanged: the first greeting of `controller` is put
/// into the socket by opening a third wire on its end, which finds none and is thrown away.
void setUp(void)
{
    hal_host_reset(tick_hz);
    sim_wire_t probe;
    TEST_ASSERT_EQUAL_INT(0, socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0, ends));
    TEST_ASSERT_FALSE(sim_wire_open(&probe, ends[1], tick_hz, &e)); // greets, nobody there yet
    TEST_ASSERT_TRUE(sim_wire_open(&lathe, ends[0], tick_hz, &e));
    TEST_ASSERT_TRUE(sim_wire_open(&controller, ends[1], tick_hz, &e));
    uint8_t greeting[64]; // the second one of the controller's end
    TEST_ASSERT_GREATER_THAN(0, (int)recv(ends[0], greeting, sizeof greeting, 0));
}

void tearDown(void)
{
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void test_sensed_whole_in_crosses_with_the_distorted_encoder(void)
{
    hal_host.in.axis_nm[hal_axis_z] = -123456;
    hal_host.in.inputs = hal_in_estop;
    hal_host.in.encoder.counts = 1000;
    hal_host_fault_counts(-7);
    hal_host_advance();
    hal_host_advance();
    const uint32_t clock = hal_host.clock;
    TEST_ASSERT_TRUE(sim_wire_send_sensed(&lathe));

    hal_host_reset(tick_hz); // the other process
    TEST_ASSERT_TRUE(sim_wire_receive_sensed(&controller));
    hal_host_advance();
    TEST_ASSERT_EQUAL_INT32(-123456, hal_host.in.axis_nm[hal_axis_z]);
    TEST_ASSERT_EQUAL_UINT32(hal_in_estop, hal_host.in.inputs);
    TEST_ASSERT_EQUAL_UINT32(993, hal_host.in.read.counts);
    TEST_ASSERT_EQUAL_UINT32(clock, hal_host.clock);
}

static void test_written_whole_out_crosses(void)
{
    hal_host.out.axis[hal_axis_u].pos_nm = 77;
    hal_host.out.spindle_mrpm = -2500000;
    hal_host.out.outputs = hal_out_enable;
    const sim_wire_played_t played = {.table_crc32 = 0xA178B769u, .phase_udeg = -5};
    TEST_ASSERT_TRUE(sim_wire_send_written(&controller, &played));
    hal_host_reset(tick_hz);
    TEST_ASSERT_TRUE(sim_wire_receive_written(&lathe));
    TEST_ASSERT_EQUAL_INT32(77, hal_host.out.axis[hal_axis_u].pos_nm);
    TEST_ASSERT_EQUAL_INT32(-2500000, hal_host.out.spindle_mrpm);
    TEST_ASSERT_EQUAL_UINT32(hal_out_enable, hal_host.out.outputs);
    TEST_ASSERT_EQUAL_HEX32(0xA178B769u, lathe.played.table_crc32);
    TEST_ASSERT_EQUAL_INT32(-5, lathe.played.phase_udeg);
}

static void test_wire_partner_gone_is_lost_for_good_and_changes_nothing(void)
{
    (void)close(ends[1]);
    ends[1] = -1;
    hal_host.out.spindle_mrpm = 5;
    TEST_ASSERT_FALSE(sim_wire_receive_written(&lathe));
    TEST_ASSERT_TRUE(lathe.is_lost);
    TEST_ASSERT_FALSE(sim_wire_send_sensed(&lathe));
    lathe.is_lost = false; // sending finds it, too
    TEST_ASSERT_FALSE(sim_wire_send_sensed(&lathe));
    TEST_ASSERT_EQUAL_INT32(5, hal_host.out.spindle_mrpm);
}

static void test_open_another_program_or_no_socket_is_refused(void)
{
    // As long as a greeting.
    TEST_ASSERT_EQUAL_INT(24, (int)send(ends[1], "xxxxxxxxxxxxxxxxxxxxxxxx", 24, 0));
    TEST_ASSERT_FALSE(sim_wire_open(&lathe, ends[0], tick_hz, &e));
    TEST_ASSERT_NOT_NULL(strstr(e.text, "another program"));
    TEST_ASSERT_FALSE(sim_wire_open(&lathe, STDERR_FILENO, tick_hz, &e));
    TEST_ASSERT_NOT_NULL(strstr(e.text, "no partner"));
    TEST_ASSERT_NOT_NULL(strstr(e.text, "let tools/live start both"));
}
