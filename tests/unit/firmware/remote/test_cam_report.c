// SPDX-License-Identifier: Apache-2.0
// What the controller sends unasked: the frames of the status, their period, and every signal of
// Detail, which is that of its page, of the value it is named for, and bounded as in camturn.dbc.
#include "cam_remote_inner.h" // cam_report_t, cam_report_send
#include "cam_machine.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"

enum { most_24 = (1 << 24) - 1 };

static fixture_can_t f;
static cam_machine_t *const m = &f.rig.machine;
static cam_status_t status;
static cam_report_t report;

static void begin(uint32_t tick_hz)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, tick_hz);
    fixture_can_start(&f);
}

void setUp(void)
{
    begin(20000);
    report = (cam_report_t){0};
    status = fixture_rig_status(&f.rig);
}

// Frames of the status

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
    g_cam.trace.n_written = UINT32_MAX - 449u; // ticks of the interrupt
    g_cam.trace.n_begun = UINT32_MAX - 449u;
    f.can.report.status_tick = UINT32_MAX - 449u;
    fixture_rig_tick(&f.rig);
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_loop(&f, 2001);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 5u * 10u, hal_host.slow.n_sent);
}

/// Periods without a poll are skipped, and a late poll does not stretch the next period. Status
/// that finds no room is lost.
static void test_late_polls_do_not_change_the_raster(void)
{
    fixture_rig_ticks(&f.rig, 1100);
    const uint32_t n_sent = hal_host.slow.n_sent;
    cam_can_poll(&f.can);
    cam_can_poll(&f.can);
    expect_status_at(n_sent);
    fixture_rig_ticks(&f.rig, 250); // 50 ticks late
    cam_can_poll(&f.can);
    fixture_rig_ticks(&f.rig, 150);
    cam_can_poll(&f.can);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 15u, hal_host.slow.n_sent);
    hal_host.slow.n_room = 1;
    fixture_can_loop(&f, 400);
    TEST_ASSERT_EQUAL_UINT32(n_sent + 16u, hal_host.slow.n_sent);
    hal_host.slow.n_room = 100;
    fixture_can_loop(&f, 200);
    expect_status_at(n_sent + 16u);
}

static void test_status_has_state_reset_and_faults(void)
{
    hal_host.slow.start.reset = hal_reset_brown_out;
    fixture_can_start(&f);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    hal_host_fault_estop(true);
    fixture_can_loop(&f, 300);
    const hal_can_frame_t frame = fixture_can_sent(0x1C0);
    TEST_ASSERT_EQUAL_UINT8(cam_state_fault, frame.data[0]);
    TEST_ASSERT_EQUAL_UINT8(hal_reset_brown_out, frame.data[1]);
    TEST_ASSERT_EQUAL_INT32(cam_ok, fixture_can_i16(&frame, 2));
    TEST_ASSERT_EQUAL_HEX32(CAM_FAULT_BIT(estop), fixture_can_i32(&frame, 4));
}

/// The newest record, a second later, with the frames of its status.
static cam_tick_record_t *one_second_later(void)
{
    static cam_tick_record_t record;
    record = *g_cam.trace.newest;
    record.tick += m->tick_hz;
    g_cam.trace.newest = &record;
    return &record;
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
        begin(cases[i].tick_hz);
        g_cam.spindle.n_late = 0x89ABCDEFu;
        cam_tick_record_t *record = one_second_later();
        record->angle.speed_q32 = cases[i].speed_q32;
        record->want.z_nm = -7654321;
        cam_can_poll(&f.can);
        record->tick += cases[i].tick_hz; // for the other page
        cam_can_poll(&f.can);
        const hal_can_frame_t spindle = fixture_can_sent(0x2C0);
        TEST_ASSERT_EQUAL_INT32(cases[i].mrpm, fixture_can_i32(&spindle, 0));
        const hal_can_frame_t z = fixture_can_detail(0);
        TEST_ASSERT_EQUAL_INT32(-7654321, fixture_can_i32(&z, 4));
        const hal_can_frame_t rate = fixture_can_detail(2);
        TEST_ASSERT_EQUAL_HEX32(cases[i].tick_hz << 8 | 2u, fixture_can_i32(&rate, 0));
        TEST_ASSERT_EQUAL_HEX32(0x89ABCDEF, fixture_can_i32(&rate, 4));
    }
}

/// The firmware counts in the sense of cutting, so with M4 the drawing's angle falls.
static void test_status_has_u_and_the_angle_of_the_drawing(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_lead_ns, 50000));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    f.rig.lathe.error_nm[hal_axis_u] = 4321;
    fixture_can_loop(&f, 1000);
    status = fixture_rig_status(&f.rig);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, status.state);
    for (int32_t direction = -1; direction <= 1; direction += 2) {
        m->table.direction = direction;
        one_second_later()->angle.pos_q32 = (INT64_C(3) << 32) + 0x12345678;
        cam_can_poll(&f.can);
        const hal_can_frame_t spindle = fixture_can_sent(0x2C0);
        TEST_ASSERT_EQUAL_HEX32(direction * 0x12345678, fixture_can_i32(&spindle, 4));
    }
    const hal_can_frame_t u = fixture_can_sent(0x3C0);
    TEST_ASSERT_INT32_WITHIN(1, status.u_set_q6 / 64, fixture_can_i32(&u, 0));
    TEST_ASSERT_EQUAL_INT32(status.u_actual_nm, fixture_can_i32(&u, 4));
    const hal_can_frame_t detail = fixture_can_detail(0);
    TEST_ASSERT_EQUAL_INT32(status.following_nm, fixture_can_i32(&detail, 0) >> 8);
    TEST_ASSERT_INT32_WITHIN(100, 4321, status.following_nm);
}

// Pages of Detail

/// @return the bits of a page, the first after the number of the page
static uint64_t bits(uint8_t page, uint32_t at, uint32_t n)
{
    hal_can_frame_t frame = {0};
    for (uint32_t i = 0; i < 32u && (i == 0u || frame.id == 0u); i++) {
        hal_host.slow.n_sent = 0;
        report.status_tick = status.tick - 200u;
        cam_report_send(&report, &f.can.store, &status);
        frame = fixture_can_detail(page);
    }
    TEST_ASSERT_EQUAL_HEX32(0x4C0, frame.id);
    uint64_t all = 0;
    for (uint32_t i = 8; i > 0u; i--) {
        all = all << 8 | frame.data[i - 1u];
    }
    return all >> at & ((UINT64_C(1) << n) - 1u);
}

static void expect(uint64_t value, uint8_t page, uint32_t at, uint32_t n)
{
    TEST_ASSERT_EQUAL_HEX64(value, bits(page, at, n));
}

/// Bits of a page.
typedef struct {
    uint64_t value;
    uint8_t page;
    uint32_t at, n;
} signal_t;

static void expect_all(const signal_t *signals, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        expect(signals[i].value, signals[i].page, signals[i].at, signals[i].n);
    }
}

static void test_signals_are_the_values_they_are_named_for(void)
{
    m->params.feed_override_ppm = 1234567;
    m->params.spindle_override_ppm = 654321;
    m->params.x_trim_nm = -98765;
    m->params.x_datum_nm = 3000000;
    m->params.tool = 4;
    m->n_parts = 0xDEADBEEFu;
    m->version = 0x7FEDCBu;
    m->checksum = 0xCAFEF00Du;
    m->scope.use = cam_scope_box;
    m->scope.phase = cam_scope_recording;
    m->scope.ring.faults = 0x87654321u;
    m->rights.commander = 200;
    m->rights.n_take_overs = 0x1A5u;
    m->rights.n_losses = 0x2C3u;
    m->rights.level = cam_level_key;
    m->rights.level_tick = status.tick;
    f.can.store.generation = 0x89ABCDEFu;
    m->table.image_size = 0xFEDCBA98u;
    m->table.crc32 = 0x12345678u;
    hal_host.slow.load.n_corrected = 0x89ABCDu;
    status.n_late = 0x89ABCDEFu;
    status.x_actual_nm = -1234567;
    status.jog.serial = 0x5ABCDu;
    status.jog.phase = cam_jog_search;
    status.jog.end = cam_jog_no_switch;
    status.jog.axis = hal_axis_z;
    TEST_ASSERT_EQUAL_INT(2, cam_jog_done); // the ends of orders have the numbers of camturn.dbc
    TEST_ASSERT_EQUAL_INT(9, cam_jog_no_stroke);
    const signal_t signals[] = {
        {20000, 2, 8, 24},
        {0x89ABCDEFu, 2, 32, 32},
        {0xABCDEF, 3, 8, 24},
        {0xFEDCBA98u, 3, 32, 32},
        {0x89ABCDu, 4, 8, 24},
        {0x12345678u, 4, 32, 32},
        {0xABCD, 16, 16, 16},
        {3000000 - 1234567, 16, 32, 32},
        {cam_jog_search, 17, 8, 8},
        {cam_jog_no_switch, 17, 16, 8},
        {hal_axis_z, 17, 24, 8},
        {4, 17, 32, 8},
        {1234567, 18, 8, 23},
        {0, 18, 31, 1},
        {0xDEADBEEFu, 18, 32, 32},
        {654321, 19, 8, 24},
        {(uint32_t)-98765, 19, 32, 32},
        {cam_kept_none, 21, 8, 4},
        {0xFEDCBu, 21, 12, 20},
        {0xCAFEF00Du, 21, 32, 32},
        {cam_scope_box, 22, 8, 8},
        {cam_scope_recording, 22, 16, 8},
        {0x87654321u, 22, 32, 32},
        {200, 25, 8, 8},
        {0xA5, 25, 16, 8},
        {0xC3, 25, 24, 8},
        {cam_level_key, 25, 32, 4},
        {cam_button_waived, 25, 36, 4},
        {cam_rights_level_s, 25, 48, 16},
    };
    TEST_ASSERT_EQUAL_INT64(0,
                            cam_offsets_origin_nm(&m->offsets, &m->params, hal_axis_x) + 3000000);
    expect_all(signals, sizeof signals / sizeof signals[0]);
    m->is_held = true;
    expect(1, 18, 31, 1);
}

/// Inputs bit by bit, the wait for the spindle, and the pass, counted from 1; a table without any
/// is 0 of 0.
static void test_page_1_has_inputs_wait_and_pass(void)
{
    static const cam_pass_t two[2] = {{1000, 100000, 1000000, 0}, {0, 100000, 1000000, 0}};
    static const struct {
        uint32_t input, sent;
        bool is_synced, is_retracted;
    } cases[] = {{hal_in_estop, 4, false, false},
                 {hal_in_drive_ready, 8, false, false},
                 {hal_in_bus_lost, 16, false, false},
                 {0, 2, false, true},
                 {0, 1, true, false}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        status.inputs = cases[i].input;
        status.is_synced = cases[i].is_synced;
        status.is_retracted = cases[i].is_retracted;
        expect(cases[i].sent, 1, 8, 24);
    }
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        status.jog.homed = 1u << axis;
        status.inputs = (uint32_t)hal_in_home_u << axis;
        expect(0x11u << axis, 16, 8, 8);
    }
    m->is_unsteady = true;
    expect(2, 1, 13, 2);
    status.steady.waited_ticks = 8;
    expect(1, 1, 13, 2);
    m->table.passes = two;
    m->table.n_passes = 2;
    m->pass = 1;
    expect(2u << 8 | 2u, 1, 16, 16);
}

static void test_learning_is_sent(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_learn_harmonics, 9));
    hal_host.slow.measures_u = true;
    m->ilc.phase = cam_ilc_cutting;
    m->ilc.hindrance = cam_ilc_fast_turn;
    m->ilc.n_orders = 7;
    m->ilc.n_turns = 0xFEDCBA98u;
    m->ilc.correction.masked = 0x1F0E5u;
    m->ilc.error_nm = 0xEDCBA987u;
    m->ilc.drive.k1_q16 = -65536; // a tick of 50 us
    m->ilc.drive.k2_q16 = -65536 * 3;
    m->ilc.correction.c_q6[3].re = 64 * 1234;
    m->ilc.speed_q32 = 1 << 22;
    m->ilc.ripple.mean[0].re = 1 << 10;
    const cam_ilc_status_t t = cam_machine_learning(m);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ilc_all, t.reason);
    TEST_ASSERT_GREATER_THAN_UINT32(0, t.ripple_nturn);
    const signal_t signals[] = {
        {cam_ilc_cutting, 11, 8, 8},
        {(uint64_t)t.reason, 11, 16, 8},
        {7, 11, 24, 8},
        {0xFEDCBA98u, 11, 32, 32},
        {0x1F0E5u, 12, 8, 24},
        {0xEDCBA987u, 12, 32, 32},
        {(uint32_t)-50000 & (uint32_t)most_24, 13, 8, 24},
        {(uint32_t)-7500, 13, 32, 32},
        {1234, 14, 32, 32},
        {t.ripple_nturn, 15, 8, 24},
        {1171875, 15, 32, 32}, // 2^22 / 2^32 turns a tick
    };
    expect_all(signals, sizeof signals / sizeof signals[0]);
}

static void test_values_are_bounded_by_their_bits(void)
{
    static const int32_t following_nm[][2] = {{8388607, 8388607},    {8388608, 8388607},
                                              {INT32_MAX, 8388607},  {-8388608, -8388608},
                                              {INT32_MIN, -8388608}, {-5, -5}};
    for (uint32_t i = 0; i < sizeof following_nm / sizeof following_nm[0]; i++) {
        status.following_nm = following_nm[i][0];
        expect((uint32_t)following_nm[i][1] & (uint32_t)most_24, 0, 8, 24);
    }
    hal_host.slow.load.n_corrected = 0x1000000u;
    expect(most_24, 4, 8, 24);
    m->ilc.drive.k1_q16 = 65536 * 200;
    expect(8388607, 13, 8, 24);
    m->ilc.drive.k1_q16 = -65536 * 200;
    expect(8388608, 13, 8, 24);
    m->ilc.begun_nm = 4321;
    expect(4321, 14, 8, 24);
    m->ilc.begun_nm = (uint32_t)most_24 + 5u;
    expect(most_24, 14, 8, 24);
    for (uint32_t k = 0; k < cam_ilc_harmonics; k++) {
        m->ilc.ripple.mean[k].re = INT16_MAX;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(most_24, cam_machine_learning(m).ripple_nturn);
    expect(most_24, 15, 8, 24);
}

/// The mean is that of the interrupts that were looked at since the page was sent last, sent or
/// not, in 10 ns; the longest is that since the start, in ns. Both end with their bits.
static void test_time_of_the_interrupt_is_sent(void)
{
    hal_host.slow.load = (hal_load_t){.cycles_hz = 400000000, .max_cycles = 8001};
    expect(20002, 1, 32, 32);
    hal_host.slow.load.last_cycles = 0;
    (void)bits(24, 8, 24);
    for (uint32_t i = 0; i < 5u; i++) { // one page or none, all are looked at
        hal_host.slow.load.last_cycles = 1000u * (i + 1u);
        report.status_tick = status.tick;
        cam_report_send(&report, &f.can.store, &status);
    }
    TEST_ASSERT_EQUAL_UINT64(15000, report.load_cycles);
    TEST_ASSERT_EQUAL_UINT32(5, report.n_loads);
    hal_host.slow.load.last_cycles = 3000;
    expect(750, 24, 32, 16);
    TEST_ASSERT_EQUAL_UINT64(0, report.load_cycles);
    TEST_ASSERT_EQUAL_UINT32(0, report.n_loads);
    report.load_cycles = 777; // begins anew after its own page, not after the next
    (void)bits(25, 8, 8);
    TEST_ASSERT_EQUAL_UINT64(3777, report.load_cycles);
    hal_host.slow.load.last_cycles = UINT32_MAX;
    hal_host.slow.load.max_cycles = UINT32_MAX;
    expect(UINT16_MAX, 24, 32, 16);
    hal_host.slow.load.cycles_hz = 1;
    expect(UINT32_MAX, 1, 32, 32);
    hal_host.slow.load.cycles_hz = 0; // the port does not measure
    expect(0, 24, 32, 16);
    expect(0, 1, 32, 32);
}

/// In 1 / 128 turn, the speed of the pass in 1 / 100 r/min; the seconds that are left for enable
/// are rounded up.
static void test_progress_and_seconds_of_the_button_are_sent(void)
{
    const cam_progress_t p = cam_progress(m);
    TEST_ASSERT_TRUE(p.has_end);
    TEST_ASSERT_GREATER_THAN_INT64(0, p.left_q32);
    expect(1, 23, 8, 1);
    expect((uint64_t)(p.left_q32 >> 25), 23, 9, 27);
    expect((uint64_t)(p.whole_q32 >> 25), 23, 36, 27);
    expect(p.mrpm / 10u, 24, 8, 24);
    static const uint32_t cases[][2] = {{25000, 50}, {24999, 51}, {25001, 50}, {149999, 1}};
    status.acknowledge.phase = cam_acknowledge_given;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        status.acknowledge.n_plans = cases[i][0];
        expect(cases[i][1], 25, 40, 8);
    }
}

static void test_every_page_comes_in_turn(void)
{
    uint32_t seen = 0;
    for (uint32_t i = 0; i < 24u; i++) {
        report.status_tick = status.tick - 200u;
        cam_report_send(&report, &f.can.store, &status);
        const uint8_t page = fixture_can_sent(0x4C0).data[0];
        TEST_ASSERT_LESS_THAN_UINT8(26, page);
        TEST_ASSERT_EQUAL_UINT32(0, seen >> page & 1u);
        seen |= UINT32_C(1) << page;
    }
    TEST_ASSERT_EQUAL_HEX32(0x3EFFFFEu, seen); // all but 0, which comes with each, and 20
}

static void test_name_of_the_table_comes_in_pieces_or_not_at_all(void)
{
    static const char name[] = "abcdefghijklmnopqrstuvwxyz01234";
    for (uint32_t i = 0; i < cam_table_name_size; i++) {
        m->table.name[i] = name[i];
    }
    for (uint32_t at = 0; at < 36u; at++) {
        const char letter = at < cam_table_name_size ? name[at] : '\0';
        expect((uint8_t)letter, (uint8_t)(5u + at / 6u), 16u + 8u * (at % 6u), 8);
    }
    m->has_table = false;
    for (uint8_t page = 3; page <= 5u; page++) {
        expect(0, page, 8, 56);
    }
}
