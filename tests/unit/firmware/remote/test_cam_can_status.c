// SPDX-License-Identifier: Apache-2.0
// What the controller sends unasked: status frames and their period. test_cam_can_text.c has the
// lines of text.
#include "cam_can.h"
#include "cam_machine.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // memset

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

static void test_status_tells_speed_and_height(void)
{
    to_cutting();
    fixture_can_loop(&f, 1000);
    hal_can_frame_t frame = fixture_can_sent(0x2C0);
    TEST_ASSERT_INT32_WITHIN(250, 2500000, fixture_can_i32(&frame, 0));
    frame = fixture_can_detail(0);
    const int32_t z_nm = fixture_can_i32(&frame, 4);
    TEST_ASSERT_GREATER_THAN_INT32(part.z_first_nm, z_nm);
    TEST_ASSERT_LESS_OR_EQUAL_INT32(part.z_last_nm, z_nm);
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

/// Let all pages of Detail be sent; the port keeps the newest frames.
static void turn_pages(uint8_t page)
{
    fixture_can_loop(&f, 1);
    for (uint32_t i = 0; i < 40u * 200u && fixture_can_detail(page).id == 0u; i += 8u) {
        fixture_rig_ticks(&f.rig, 7);
        fixture_can_loop(&f, 1);
    }
    TEST_ASSERT_EQUAL_HEX32(0x4C0, fixture_can_detail(page).id);
}

static void expect_longest_tick(uint32_t cycles, uint32_t cycles_hz, uint32_t ns)
{
    hal_host.slow.load = (hal_load_t){.max_cycles = cycles, .cycles_hz = cycles_hz};
    hal_host.slow.n_sent = 0;
    memset(hal_host.slow.sent, 0, sizeof hal_host.slow.sent);
    turn_pages(1);
    const hal_can_frame_t frame = fixture_can_detail(1);
    TEST_ASSERT_EQUAL_HEX32(ns, fixture_can_i32(&frame, 4));
}

static void test_status_tells_the_longest_tick(void)
{
    expect_longest_tick(4800, 480000000, 10000);
    expect_longest_tick(0xFEDCBA98u, 400000000, UINT32_MAX); // more than the signal can hold
    expect_longest_tick(1, 480000000, 2);
    expect_longest_tick(77, 0, 0); // not measured
}

/// @return the bits of a page, the first behind the number of the page
static uint64_t bits(uint8_t page, uint32_t at, uint32_t n)
{
    hal_host.slow.n_sent = 0;
    memset(hal_host.slow.sent, 0, sizeof hal_host.slow.sent);
    turn_pages(page);
    const hal_can_frame_t frame = fixture_can_detail(page);
    uint64_t all = 0;
    for (uint32_t i = 8; i > 0u; i--) {
        all = all << 8 | frame.data[i - 1u];
    }
    return all >> at & ((UINT64_C(1) << n) - 1u);
}

/// The mean is of the ticks since the page was sent last.
static void test_status_tells_the_mean_tick(void)
{
    hal_host.slow.load = (hal_load_t){.last_cycles = 2400, .cycles_hz = 480000000};
    (void)bits(24, 32, 16);
    TEST_ASSERT_EQUAL_UINT64(500, bits(24, 32, 16)); // 5 us
    hal_host.slow.load.last_cycles = 4800;
    (void)bits(24, 32, 16);
    TEST_ASSERT_EQUAL_UINT64(1000, bits(24, 32, 16));
    hal_host.slow.load.last_cycles = UINT32_MAX;
    (void)bits(24, 32, 16);
    TEST_ASSERT_EQUAL_UINT64(UINT16_MAX, bits(24, 32, 16));
    hal_host.slow.load.cycles_hz = 0;
    TEST_ASSERT_EQUAL_UINT64(0, bits(24, 32, 16)); // not measured
}

static void test_status_tells_turns_and_speed_of_the_pass(void)
{
    fixture_can_loop(&f, 1);
    const cam_progress_t p = cam_progress(&f.rig.machine);
    TEST_ASSERT_EQUAL_UINT64(1, bits(23, 8, 1));
    TEST_ASSERT_EQUAL_UINT64(p.left_q32 >> 25, bits(23, 9, 27));
    TEST_ASSERT_EQUAL_UINT64(p.whole_q32 >> 25, bits(23, 36, 27));
    TEST_ASSERT_GREATER_THAN_UINT64(128u * 10u, bits(23, 36, 27)); // ten turns of feed
    TEST_ASSERT_EQUAL_UINT64(250000, bits(24, 8, 24));
    f.rig.machine.strobe.n_lost = 0x12345;
    TEST_ASSERT_EQUAL_HEX64(0x2345, bits(24, 48, 16));
    f.rig.machine.has_table = false;
    TEST_ASSERT_EQUAL_UINT64(0, bits(23, 8, 55));
}

static void test_status_tells_late_ticks(void)
{
    to_cutting();
    hal_host_fault_late(80);
    fixture_rig_tick(&f.rig);
    turn_pages(2);
    const hal_can_frame_t frame = fixture_can_detail(2);
    TEST_ASSERT_EQUAL_INT32(1, fixture_can_i32(&frame, 4));
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

static void test_status_tells_inputs_and_that_the_angle_is_known(void)
{
    turn_pages(1);
    hal_can_frame_t frame = fixture_can_detail(1);
    TEST_ASSERT_EQUAL_HEX8(8, frame.data[1] & 0xDu); // drives ready, no angle, no stop
    frame = fixture_can_sent(0x2C0);
    TEST_ASSERT_EQUAL_HEX32(0, fixture_can_i32(&frame, 4));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    hal_host.slow.n_sent = 0;
    memset(hal_host.slow.sent, 0, sizeof hal_host.slow.sent);
    turn_pages(1);
    frame = fixture_can_detail(1);
    TEST_ASSERT_EQUAL_HEX8(9, frame.data[1] & 0xDu);
}

static void test_status_tells_the_pass(void)
{
    static const cam_pass_t two[2] = {{1000, 100000, 1000000, 0}, {0, 100000, 1000000, 0}};
    turn_pages(1);
    TEST_ASSERT_EQUAL_HEX16(0, fixture_can_detail(1).data[2] | fixture_can_detail(1).data[3]);
    f.rig.machine.table.passes = two;
    f.rig.machine.table.n_passes = 2;
    f.rig.machine.pass = 1;
    hal_host.slow.n_sent = 0;
    memset(hal_host.slow.sent, 0, sizeof hal_host.slow.sent);
    turn_pages(1);
    TEST_ASSERT_EQUAL_UINT8(2, fixture_can_detail(1).data[2]);
    TEST_ASSERT_EQUAL_UINT8(2, fixture_can_detail(1).data[3]);
}

static void test_status_tells_the_table(void)
{
    char name[37] = "";
    for (uint8_t i = 0; i < 6u; i++) {
        turn_pages((uint8_t)(5u + i));
        memcpy(name + 6 * i, fixture_can_detail((uint8_t)(5u + i)).data + 2, 6);
    }
    TEST_ASSERT_EQUAL_STRING("short skirt", name);
    turn_pages(3);
    hal_can_frame_t frame = fixture_can_detail(3);
    TEST_ASSERT_EQUAL_HEX32(1u << 8 | 3u, fixture_can_i32(&frame, 0)); // generation
    TEST_ASSERT_EQUAL_UINT32(f.rig.image.size, fixture_can_i32(&frame, 4));
    turn_pages(4);
    frame = fixture_can_detail(4);
    TEST_ASSERT_EQUAL_HEX32(f.rig.machine.table.crc32, fixture_can_i32(&frame, 4));
}

static void test_without_a_table_there_is_nothing_to_tell_of_it(void)
{
    hal_host.slow.table.size = 0;
    fixture_can_start(&f);
    turn_pages(3);
    const hal_can_frame_t frame = fixture_can_detail(3);
    static const uint8_t bytes[] = {3, 0, 0, 0, 0, 0, 0, 0};
    TEST_ASSERT_EQUAL_MEMORY(bytes, frame.data, sizeof bytes);
}
