// SPDX-License-Identifier: Apache-2.0
// Every signal of Detail is that of its page, of the value it is named for, and bounded as
// camturn.dbc says.
#include "cam_report.h"
#include "cam_offsets.h"
#include "cam_machine.h"
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"

enum { most_24 = (1 << 24) - 1 };

static fixture_can_t f;
static cam_machine_t *m;
static cam_status_t status;
static cam_report_t report;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
    m = &f.rig.machine;
    report = (cam_report_t){0};
    status = fixture_rig_status(&f.rig);
}

/// @return the bits of a page, the first behind the number of the page
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

static void test_inputs_are_told_bit_by_bit(void)
{
    static const struct {
        uint32_t input, bit;
    } cases[] = {{hal_in_estop, 2}, {hal_in_drive_ready, 3}, {hal_in_bus_lost, 4}};
    status.is_synced = false;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        status.inputs = cases[i].input;
        status.is_retracted = i == 1u;
        expect(1u << cases[i].bit | (i == 1u ? 2u : 0u), 1, 8, 5);
    }
    status.inputs = 0;
    status.is_synced = true;
    expect(1, 1, 8, 5);
}

static void test_memory_errors_are_sent_with_the_crc(void)
{
    hal_host.slow.load.n_corrected = 0x89ABCDu;
    expect(0x89ABCDu, 4, 8, 24);
    hal_host.slow.load.n_corrected = 0x1000000u; // more than the signal holds
    expect(0xFFFFFFu, 4, 8, 24);
}

static void test_late_ticks_are_told_beside_the_rate(void)
{
    status.n_late = 0x89ABCDEFu;
    expect(20000, 2, 8, 24);
    expect(0x89ABCDEFu, 2, 32, 32);
}

/// Page 1 counts passes from 1; a table without any is 0 of 0.
static void test_pass_is_told(void)
{
    static const cam_pass_t two[2] = {{1000, 100000, 1000000, 0}, {0, 100000, 1000000, 0}};
    expect(0, 1, 16, 16);
    m->table.passes = two;
    m->table.n_passes = 2;
    m->pass = 1;
    expect(2u << 8 | 2u, 1, 16, 16);
}

static void test_following_error_is_bounded_by_its_bits(void)
{
    static const int32_t cases[][2] = {{8388607, 8388607},    {8388608, 8388607},
                                       {INT32_MAX, 8388607},  {-8388608, -8388608},
                                       {INT32_MIN, -8388608}, {-5, -5}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        status.following_nm = cases[i][0];
        expect((uint32_t)cases[i][1] & (uint32_t)most_24, 0, 8, 24);
    }
}

static void test_learning_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_learn_harmonics, 9));
    hal_host.slow.measures_u = true;
    m->ilc.phase = cam_ilc_cutting;
    m->ilc.hindrance = cam_ilc_fast_turn;
    m->ilc.n_orders = 7;
    m->ilc.n_turns = 0xFEDCBA98u;
    m->ilc.correction.masked = 0x1F0E5u;
    m->ilc.error_nm = 0xEDCBA987u;
    m->ilc.k1_q16 = -65536; // a tick of 50 us
    m->ilc.k2_q16 = -65536 * 3;
    m->ilc.correction.c_q6[3].re = 64 * 1234;
    m->ilc.speed_q32 = 1 << 22;
    m->ilc.ripple.mean[0].re = 1 << 10;
    const cam_ilc_status_t t = cam_machine_learning(m);
    expect(cam_ilc_cutting, 11, 8, 8);
    expect((uint64_t)t.reason, 11, 16, 8);
    TEST_ASSERT_NOT_EQUAL_INT(cam_ilc_all, t.reason);
    expect(7, 11, 24, 8);
    expect(0xFEDCBA98u, 11, 32, 32);
    expect(0x1F0E5u, 12, 8, 24);
    expect(0xEDCBA987u, 12, 32, 32);
    expect((uint32_t)-50000 & (uint32_t)most_24, 13, 8, 24);
    expect((uint32_t)-7500, 13, 32, 32);
    expect(1234, 14, 32, 32);
    expect(t.ripple_nturn, 15, 8, 24);
    TEST_ASSERT_GREATER_THAN_UINT32(0, t.ripple_nturn);
    expect(1171875, 15, 32, 32); // 2^22 / 2^32 turns a tick
}

static void test_learning_is_bounded_by_its_bits(void)
{
    m->ilc.k1_q16 = 65536 * 200;
    expect(8388607, 13, 8, 24);
    m->ilc.k1_q16 = -65536 * 200;
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

static void test_wait_for_the_spindle_is_told(void)
{
    expect(0, 1, 13, 2);
    m->is_unsteady = true;
    expect(2, 1, 13, 2);
    status.steady.waited_ticks = 8;
    expect(1, 1, 13, 2);
}

static void test_hand_is_told_bit_by_bit(void)
{
    for (uint32_t axis = 0; axis < hal_n_axes; axis++) {
        status.jog.homed = 1u << axis;
        status.inputs = (uint32_t)hal_in_home_u << axis;
        expect(0x11u << axis, 16, 8, 8);
    }
    m->params.x_datum_nm = 3000000;
    status.x_actual_nm = -1234567;
    status.jog.serial = 0x5ABCDu;
    expect(0xABCD, 16, 16, 16);
    const int64_t x_nm =
        status.x_actual_nm - cam_offsets_origin_nm(&m->offsets, &m->params, hal_axis_x);
    expect((uint32_t)(int32_t)x_nm, 16, 32, 32);
    TEST_ASSERT_EQUAL_INT64(3000000 - 1234567, x_nm);
    status.jog.phase = cam_jog_search;
    status.jog.end = cam_jog_no_switch;
    status.jog.axis = hal_axis_z;
    m->params.tool = 4;
    expect(cam_jog_search, 17, 8, 8);
    expect(cam_jog_no_switch, 17, 16, 8);
    expect(hal_axis_z, 17, 24, 8);
    expect(4, 17, 32, 8);
}

static void test_changes_are_told(void)
{
    m->params.feed_override_ppm = 1234567;
    m->params.spindle_override_ppm = 654321;
    m->params.x_trim_nm = -98765;
    m->n_parts = 0xDEADBEEFu;
    expect(1234567, 18, 8, 23);
    expect(0, 18, 31, 1);
    m->is_held = true;
    expect(1, 18, 31, 1);
    expect(0xDEADBEEFu, 18, 32, 32);
    expect(654321, 19, 8, 24);
    expect((uint32_t)-98765, 19, 32, 32);
}

static void test_version_of_the_parameters_keeps_its_lower_bits(void)
{
    m->version = 0x7FEDCBu;
    m->checksum = 0xCAFEF00Du;
    expect(0xFEDCBu, 21, 12, 20);
    expect(0xCAFEF00Du, 21, 32, 32);
}

static void test_recorder_is_told(void)
{
    m->scope.use = cam_scope_box;
    m->scope.phase = cam_scope_recording;
    m->scope.ring.faults = 0x87654321u;
    expect(cam_scope_box, 22, 8, 8);
    expect(cam_scope_recording, 22, 16, 8);
    expect(0x87654321u, 22, 32, 32);
}

static void test_rights_are_told(void)
{
    m->rights.commander = 200;
    m->rights.n_take_overs = 0x1A5u;
    m->rights.n_losses = 0x2C3u;
    m->rights.level = cam_level_challenge;
    m->rights.level_tick = status.tick;
    expect(200, 25, 8, 8);
    expect(0xA5, 25, 16, 8);
    expect(0xC3, 25, 24, 8);
    expect(cam_level_challenge, 25, 32, 4);
    expect(cam_rights_level_s, 25, 48, 16);
}

/// The seconds that are left for enable are rounded up.
static void test_button_is_told_with_its_seconds(void)
{
    static const uint32_t cases[][2] = {{25000, 50}, {24999, 51}, {25001, 50}, {149999, 1}};
    status.acknowledge.phase = cam_acknowledge_given;
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        status.acknowledge.n_plans = cases[i][0];
        expect(cases[i][1], 25, 40, 8);
    }
}

/// The mean is that of the interrupts that were looked at since the page was sent last, sent or
/// not, in 10 ns; the longest is that since the start, in ns. Both end with their bits.
static void test_time_of_the_interrupt_is_told(void)
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
    report.load_cycles = 777; // begins anew behind its own page, not behind the next
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

/// Turns are told in 1 / 128, the speed of the pass in 1 / 100 r/min.
static void test_progress_is_told(void)
{
    const cam_progress_t p = cam_progress(m);
    TEST_ASSERT_TRUE(p.has_end);
    TEST_ASSERT_GREATER_THAN_INT64(0, p.left_q32);
    expect(1, 23, 8, 1);
    expect((uint64_t)(p.left_q32 >> 25), 23, 9, 27);
    expect((uint64_t)(p.whole_q32 >> 25), 23, 36, 27);
    expect(p.mrpm / 10u, 24, 8, 24);
    m->strobe.n_lost = 0x5ABCDu;
    expect(0xABCD, 24, 48, 16);
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
    TEST_ASSERT_EQUAL_HEX32(0x3EFFFFEu, seen); // all but 0, which comes beside each, and 20
}

static void test_pages_of_the_table_hold_its_name_in_pieces(void)
{
    static const char name[] = "abcdefghijklmnopqrstuvwxyz01234";
    for (uint32_t i = 0; i < cam_table_name_size; i++) {
        m->table.name[i] = name[i];
    }
    m->table.image_size = 0xFEDCBA98u;
    m->table.crc32 = 0x12345678u;
    expect(0xFEDCBA98u, 3, 32, 32);
    expect(0x12345678u, 4, 32, 32);
    f.can.store.generation = 0x89ABCDEFu;
    expect(0xABCDEF, 3, 8, 24);
    for (uint8_t k = 0; k < 6u; k++) {
        for (uint32_t i = 0; i < 6u; i++) {
            const uint32_t at = 6u * k + i;
            const char letter = at < cam_table_name_size ? name[at] : '\0';
            expect((uint8_t)letter, (uint8_t)(5u + k), 16u + 8u * i, 8);
        }
    }
}

static void test_without_a_table_nothing_is_told_of_one(void)
{
    m->has_table = false;
    expect(0, 3, 8, 56);
    expect(0, 4, 8, 56);
    expect(0, 5, 8, 56);
}

/// What came of an order by hand has the number of camturn.dbc.
static void test_ends_of_orders_by_hand_are_those_of_the_bus(void)
{
    TEST_ASSERT_EQUAL_INT(1, cam_jog_runs);
    TEST_ASSERT_EQUAL_INT(2, cam_jog_done);
    TEST_ASSERT_EQUAL_INT(9, cam_jog_no_stroke);
}
