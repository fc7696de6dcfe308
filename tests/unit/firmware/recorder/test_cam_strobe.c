// SPDX-License-Identifier: Apache-2.0
// Samples of single ticks: their raster, their queue, and who reads the trace ring for them.
#include "cam_recorder.h"
#include "cam_machine_inner.h" // cam_machine_scope_set, cam_machine_scope_start
#include "cam_tick_inner.h"    // cam_trace_begin_isr, cam_trace_commit_isr
#include "fixture_rig.h"
#include "unity.h"
#include <string.h> // memset

enum { every = 40, tick_hz = 20000, hold_ticks = cam_strobe_hold_s * tick_hz };

static cam_strobe_t strobe;
static fixture_rig_t rig;

void setUp(void)
{
    memset(&strobe, 0, sizeof strobe);
}

static cam_tick_record_t record(uint32_t tick)
{
    cam_tick_record_t r = {.tick = tick};
    r.want.state = cam_state_cutting;
    r.want.u_due_q6 = (int32_t)tick * 64 - 1; // a 64th of a nanometre below
    r.in.actual_nm[hal_axis_u] = 3 * (int32_t)tick;
    r.angle.pos_q32 = (int64_t)tick << 24;
    r.angle.is_synced = true;
    return r;
}

static void take(uint32_t tick)
{
    const cam_tick_record_t r = record(tick);
    cam_strobe_take(&strobe, &r);
}

static void take_many(uint32_t from, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        take(from + i);
    }
}

/// Take the oldest sample, which must have a number.
static cam_strobe_sample_t expect(uint32_t number)
{
    const cam_strobe_sample_t *oldest = cam_strobe_oldest(&strobe);
    TEST_ASSERT_NOT_NULL(oldest);
    const cam_strobe_sample_t sample = *oldest;
    TEST_ASSERT_EQUAL_UINT32(number, sample.number);
    cam_strobe_drop(&strobe);
    return sample;
}

static void test_the_least_distance_keeps_the_rate(void)
{
    static const uint32_t rates_hz[] = {500, 501, 999, 1000, 8192, 20000, 100000};
    for (uint32_t i = 0; i < sizeof rates_hz / sizeof rates_hz[0]; i++) {
        const uint32_t least = cam_strobe_least(rates_hz[i]);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(cam_strobe_hz * least, rates_hz[i]);
        TEST_ASSERT_GREATER_THAN_UINT32(rates_hz[i], cam_strobe_hz * (least + 1u));
    }
}

static void test_a_sample_is_one_record(void)
{
    cam_strobe_subscribe(&strobe, every, 99);
    cam_tick_record_t r = record(100);
    r.angle.pos_q32 = INT64_C(-3) * 4294967296 + 0x1234FFFF;
    r.want.u_due_q6 = -129; // the recording's u_due_q6 >> 6 is -3
    r.in.actual_nm[hal_axis_u] = 40;
    r.want.state = cam_state_holding;
    r.angle.is_synced = false;
    cam_strobe_take(&strobe, &r);
    const cam_strobe_sample_t sample = expect(0);
    TEST_ASSERT_EQUAL_HEX32(0xFFFD1234, sample.pos_q16);
    TEST_ASSERT_EQUAL_INT32(43, sample.following_nm);
    TEST_ASSERT_EQUAL_INT(cam_state_holding, sample.state);
    TEST_ASSERT_FALSE(sample.is_synced);
}

/// Across the wrap of the tick as well.
static void test_samples_are_equally_far_apart(void)
{
    const uint32_t begin = UINT32_MAX - 5u * every;
    cam_strobe_subscribe(&strobe, every, begin);
    take(begin); // of the tick in which it was asked for: not later
    TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
    for (uint32_t i = 0; i < 10u; i++) {
        const uint32_t tick = begin + 1u + i * every;
        take_many(tick, every);
        TEST_ASSERT_EQUAL_INT32(3 * (int32_t)tick - (int32_t)(tick - 1u), expect(i).following_nm);
        TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
    }
    TEST_ASSERT_EQUAL_UINT32(0, strobe.n_lost);
}

static void test_lost_records_leave_a_gap_in_the_numbers(void)
{
    cam_strobe_subscribe(&strobe, every, 0);
    take(1);
    take(1 + 3 * every); // those of 1 and 2 are gone, this is 3
    take(2 + 5 * every); // 4 is gone, and 5 by one tick
    take(1 + 6 * every);
    (void)expect(0);
    (void)expect(3);
    (void)expect(6);
    TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
    TEST_ASSERT_EQUAL_UINT32(4, strobe.n_lost);
}

static void test_a_full_queue_loses_what_comes(void)
{
    cam_strobe_subscribe(&strobe, 1, 0);
    take_many(1, cam_strobe_capacity + 3);
    TEST_ASSERT_EQUAL_UINT32(3, strobe.n_lost);
    (void)expect(0);
    take(cam_strobe_capacity + 4);
    for (uint32_t i = 1; i < (uint32_t)cam_strobe_capacity; i++) {
        (void)expect(i);
    }
    (void)expect(cam_strobe_capacity + 3);
    TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
}

static void test_a_renewal_goes_on_and_another_distance_begins_anew(void)
{
    cam_strobe_subscribe(&strobe, every, 0);
    take_many(1, every);
    cam_strobe_subscribe(&strobe, every, every);
    take_many(every + 1, every);
    (void)expect(0);
    cam_strobe_subscribe(&strobe, every + 1, 2 * every);
    TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
    take(2 * every + 1);
    (void)expect(0);
    cam_strobe_subscribe(&strobe, 0, 2 * every + 1);
    take_many(2 * every + 2, 3 * every);
    TEST_ASSERT_NULL(cam_strobe_oldest(&strobe));
    TEST_ASSERT_FALSE(cam_strobe_is_on(&strobe));
}

static void test_it_ends_when_it_is_not_renewed(void)
{
    const uint32_t begin = UINT32_MAX - 100u;
    cam_strobe_subscribe(&strobe, every, begin);
    cam_strobe_expire(&strobe, begin + hold_ticks, tick_hz);
    TEST_ASSERT_TRUE(cam_strobe_is_on(&strobe));
    cam_strobe_subscribe(&strobe, every, begin + 7u);
    cam_strobe_expire(&strobe, begin + 7u + hold_ticks, tick_hz);
    TEST_ASSERT_TRUE(cam_strobe_is_on(&strobe));
    cam_strobe_expire(&strobe, begin + 8u + hold_ticks, tick_hz);
    TEST_ASSERT_FALSE(cam_strobe_is_on(&strobe));
}

// Of a machine

static void begin(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_rig_init(&rig, &part, tick_hz);
}

/// Put records of ticks into the ring.
static void write_ring(uint32_t from, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_tick_record_t *next = cam_trace_begin_isr(&g_cam.trace);
        *next = record(from + i);
        cam_trace_commit_isr(&g_cam.trace, next);
    }
}

static void test_the_ring_is_left_alone_when_nobody_waits(void)
{
    begin();
    write_ring(1, 4);
    cam_machine_scope_poll(&rig.machine);
    cam_tick_record_t left;
    TEST_ASSERT_TRUE(cam_trace_pop(&g_cam.trace, &left));
    TEST_ASSERT_EQUAL_UINT32(1, left.tick);
}

/// A reader that is late by more than the ring goes on with the oldest record that is whole.
static void test_records_that_nobody_read_are_missed(void)
{
    cam_tick_record_t oldest;
    begin();
    while (cam_trace_pop(&g_cam.trace, &oldest)) {
    }
    const uint32_t n_missed = g_cam.trace.n_missed;
    write_ring(1, cam_trace_capacity + 3);
    TEST_ASSERT_TRUE(cam_trace_pop(&g_cam.trace, &oldest));
    TEST_ASSERT_EQUAL_UINT32(n_missed + 4u, g_cam.trace.n_missed);
    TEST_ASSERT_EQUAL_UINT32(5, oldest.tick);
}

/// Both get every record, whichever of them began first.
static void test_recorder_and_samples_share_the_records(void)
{
    begin();
    const uint32_t now = fixture_rig_status(&rig).tick;
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_machine_strobe(&rig.machine, 39));
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_machine_strobe(&rig.machine, tick_hz + 1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_strobe(&rig.machine, 40));
    write_ring(now + 1u, 10);
    cam_machine_scope_poll(&rig.machine);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_set(&rig.machine, cam_scope_field_rows, 60));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(&rig.machine));
    write_ring(now + 11u, 100);
    cam_machine_scope_poll(&rig.machine);
    TEST_ASSERT_EQUAL_INT(cam_scope_full, rig.machine.scope.end);
    TEST_ASSERT_EQUAL_UINT32(now + 11u, rig.machine.scope.ring.first_tick);
    TEST_ASSERT_EQUAL_UINT32(3, rig.machine.strobe.n_in);
    TEST_ASSERT_EQUAL_UINT32(0, rig.machine.strobe.n_lost);
    rig.machine.strobe.renewed_tick -= 2u * hold_ticks;
    cam_machine_scope_poll(&rig.machine);
    TEST_ASSERT_FALSE(cam_strobe_is_on(&rig.machine.strobe));
}
