// SPDX-License-Identifier: Apache-2.0
// What the controller sends unasked: status frames and their period. test_cam_report.c has the
// pages of Detail, test_cam_can_text.c the lines of text.
#include "cam_can.h"
#include "cam_machine.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"

static fixture_can_t f;
static fixture_part_t part;

static void begin(uint32_t tick_hz)
{
    part = fixture_part_short();
    fixture_can_init(&f, &part, tick_hz);
    fixture_can_start(&f);
}

void setUp(void)
{
    begin(20000);
}

static void to_cutting(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_lead_ns, 50000));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
}

/// One poll sends five frames with these ids and eight bytes each.
static void expect_status_at(uint32_t n_sent)
{
    static const uint32_t ids[] = {0x1C0, 0x2C0, 0x3C0, 0x4C0, 0x4C0};
    TEST_ASSERT_EQUAL_UINT32(n_sent + 5u, hal_host.slow.n_sent);
    for (uint32_t i = 0; i < 5u; i++) {
        const hal_can_frame_t *frame = &hal_host.slow.sent[(n_sent + i) % hal_host_can_frames];
        TEST_ASSERT_EQUAL_HEX32(ids[i], frame->id);
        TEST_ASSERT_EQUAL_UINT32(8, frame->n);
    }
}

static void test_status_comes_every_ten_milliseconds(void)
{
    static const uint32_t rates_hz[] = {500, 8000, 20000, 100000};
    for (uint32_t i = 0; i < sizeof rates_hz / sizeof rates_hz[0]; i++) {
        begin(rates_hz[i]);
        for (uint32_t k = 0; k < 5u; k++) {
            const uint32_t n_sent = hal_host.slow.n_sent;
            for (uint32_t tick = 0; tick < rates_hz[i] / 100u; tick++) {
                cam_can_poll(&f.can);
                TEST_ASSERT_EQUAL_UINT32(n_sent, hal_host.slow.n_sent);
                fixture_rig_tick(&f.rig);
            }
            cam_can_poll(&f.can);
            cam_can_poll(&f.can); // must not send a second time
            expect_status_at(n_sent);
        }
    }
}

static void test_status_keeps_its_period_across_the_wrap_of_the_tick(void)
{
    g_cam.n_ticks = UINT32_MAX - 449u; // ticks of the interrupt
    g_cam.n_begun = UINT32_MAX - 450u;
    f.can.report.status_tick = UINT32_MAX - 449u;
    fixture_rig_tick(&f.rig);
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_loop(&f, 2001);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 5u * 10u, hal_host.slow.n_sent);
}

static void test_periods_without_a_poll_are_skipped(void)
{
    fixture_rig_ticks(&f.rig, 1100);
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_can_poll(&f.can);
    cam_can_poll(&f.can);
    expect_status_at(n_sent);
}

static void test_a_late_poll_does_not_stretch_the_period(void)
{
    fixture_rig_ticks(&f.rig, 250); // 50 ticks late
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_can_poll(&f.can);
    fixture_rig_ticks(&f.rig, 150);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 10u, hal_host.slow.n_sent);
}

static void test_status_that_finds_no_room_is_lost_without_harm(void)
{
    hal_host.slow.n_room = 1;
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_loop(&f, 400);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 1u, hal_host.slow.n_sent);
    hal_host.slow.n_room = 100;
    fixture_can_loop(&f, 200);
    expect_status_at(n_sent + 1u);
}

static void test_status_tells_state_reset_and_faults(void)
{
    hal_host.slow.start.reset = hal_reset_brown_out;
    fixture_can_start(&f);
    to_cutting();
    hal_host_fault_estop(true);
    fixture_can_loop(&f, 300);
    const hal_can_frame_t frame = fixture_can_sent(0x1C0);
    TEST_ASSERT_EQUAL_UINT8(cam_state_fault, frame.data[0]);
    TEST_ASSERT_EQUAL_UINT8(hal_reset_brown_out, frame.data[1]);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_i16(&frame, 2));
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_can_i32(&frame, 4));
}

/// Let the interrupt publish a speed and a height, and read them back from the bus.
static hal_can_frame_t motion_of(uint32_t tick_hz, int32_t speed_q32, int32_t z_nm)
{
    begin(tick_hz);
    static cam_tick_record_t record;
    record = *g_cam.newest;
    record.tick += tick_hz;
    record.angle.speed_q32 = speed_q32;
    record.want.z_nm = z_nm;
    g_cam.newest = &record;
    g_cam.spindle.n_late = 0x89ABCDEFu;
    cam_can_poll(&f.can);
    record.tick += tick_hz;
    cam_can_poll(&f.can);
    return fixture_can_sent(0x2C0);
}

static void test_speed_is_rounded_signed_and_saturated(void)
{
    static const struct {
        uint32_t tick_hz;
        int32_t speed_q32, mrpm;
    } cases[] = {
        {20000, 8947849, 2500000}, // 2 500 000.1
        {20000, -8947849, -2500000},
        {20000, 2, 1}, // 0.56
        {20000, 1, 0}, // 0.28
        {20000, -1, 0},
        {20000, -2, -1},
        {500, INT32_MAX, 15000000},
        {500, INT32_MIN, -15000000},
        {100000, INT32_MAX, INT32_MAX},
        {100000, INT32_MIN, INT32_MIN},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const hal_can_frame_t frame = motion_of(cases[i].tick_hz, cases[i].speed_q32, -7654321);
        TEST_ASSERT_EQUAL_INT32(cases[i].mrpm, fixture_can_i32(&frame, 0));
        const hal_can_frame_t z = fixture_can_detail(0);
        TEST_ASSERT_EQUAL_INT32(-7654321, fixture_can_i32(&z, 4));
        const hal_can_frame_t rate = fixture_can_detail(2);
        TEST_ASSERT_EQUAL_HEX32(cases[i].tick_hz << 8 | 2u, fixture_can_i32(&rate, 0));
        TEST_ASSERT_EQUAL_HEX32(0x89ABCDEF, fixture_can_i32(&rate, 4));
    }
}

static void test_status_tells_u(void)
{
    to_cutting();
    f.rig.lathe.error_nm[hal_axis_u] = 4321;
    fixture_can_loop(&f, 1000);
    const cam_status_t status = fixture_rig_status(&f.rig);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, status.state);
    static cam_tick_record_t record;
    record = *g_cam.newest;
    record.tick += 20000u;
    g_cam.newest = &record;
    cam_can_poll(&f.can);
    const hal_can_frame_t u = fixture_can_sent(0x3C0);
    TEST_ASSERT_INT32_WITHIN(1, status.u_set_q6 / 64, fixture_can_i32(&u, 0));
    TEST_ASSERT_EQUAL_INT32(status.u_actual_nm, fixture_can_i32(&u, 4));
    const hal_can_frame_t detail = fixture_can_detail(0);
    TEST_ASSERT_EQUAL_INT32(status.following_nm, fixture_can_i32(&detail, 0) >> 8);
    TEST_ASSERT_INT32_WITHIN(100, 4321, status.following_nm);
    const hal_can_frame_t spindle = fixture_can_sent(0x2C0);
    TEST_ASSERT_EQUAL_HEX32((uint32_t)(uint64_t)status.pos_q32, fixture_can_i32(&spindle, 4));
}

/// The firmware counts in the sense of cutting, so with M4 the drawing's angle falls.
static void test_status_tells_the_angle_of_the_drawing(void)
{
    to_cutting();
    static cam_tick_record_t record;
    record = *g_cam.newest;
    for (int32_t direction = -1; direction <= 1; direction += 2) {
        f.rig.machine.table.direction = direction;
        record.angle.pos_q32 = (INT64_C(3) << 32) + 0x12345678;
        record.tick += 20000u;
        g_cam.newest = &record;
        cam_can_poll(&f.can);
        const hal_can_frame_t spindle = fixture_can_sent(0x2C0);
        const uint32_t angle_q32 = direction > 0 ? 0x12345678u : 0u - 0x12345678u;
        TEST_ASSERT_EQUAL_HEX32(angle_q32, (uint32_t)fixture_can_i32(&spindle, 4));
    }
}
