// SPDX-License-Identifier: Apache-2.0
// The black box around faults of a machine, and who has the memory of the recorder.
#define OWN_SET_UP
#include "cam_machine_inner.h" // cam_machine_blackbox, cam_machine_release
#include "rig_bench.h"

enum {
    tick_hz = 10000, ///< so that the box has every tick in the memory of an emulated board, too
    n_before = tick_hz / 2,
    n_behind = tick_hz / 50,
    n_signals = 9,
    axi_words = 384 * 1024 / 4, ///< of the STM32H743
};

void setUp(void)
{
    part = fixture_part_short();
    fixture_rig_init(&rig, &part, tick_hz);
    cam_machine_blackbox(&rig.machine);
}

static cam_scope_t *scope(void)
{
    return &rig.machine.scope;
}

/// Ticks with main()'s part in between, as often as it comes round on a machine.
static void go_on(uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        if (i % 8u == 0u || n - i < 8u) {
            cam_machine_poll(&rig.machine);
        }
        fixture_rig_tick(&rig);
    }
}

/// Press the emergency stop in ready and let the box end. @return tick of the fault
static uint32_t fail(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    go_on(n_before + 100);
    hal_host_fault_estop(true);
    go_on(1);
    const uint32_t tick = rig.last.tick;
    TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
    go_on(n_behind + 10);
    TEST_ASSERT_TRUE(cam_blackbox_is_unread(scope()));
    return tick;
}

/// @return a word of the box, by its row in time
static int32_t word(uint32_t row, uint32_t column)
{
    int32_t value = 0;
    const cam_scope_span_t span = cam_scope_span(scope(), (row * n_signals + column) * 4u, 4);
    TEST_ASSERT_EQUAL_UINT32(4, span.n);
    memcpy(&value, span.bytes, sizeof value);
    return value;
}

/// The box is that of the fault in a tick.
static void expect_box(uint32_t tick)
{
    const cam_scope_t *s = scope();
    TEST_ASSERT_TRUE(cam_blackbox_is_unread(s));
    TEST_ASSERT_EQUAL_UINT32(tick, s->ring.trigger_tick);
    TEST_ASSERT_EQUAL_UINT32(CAM_FAULT_BIT(estop), s->ring.faults);
    TEST_ASSERT_EQUAL_UINT32(n_before, s->ring.n_before);
    TEST_ASSERT_EQUAL_UINT32(n_before + n_behind, s->ring.n_rows);
    TEST_ASSERT_EQUAL_UINT32(tick - n_before, s->ring.first_tick);
}

static void test_half_a_second_before_a_fault_is_there(void)
{
    expect_box(fail());
    TEST_ASSERT_EQUAL_UINT32(n_signals, scope()->n_signals);
    TEST_ASSERT_EQUAL_INT32(cam_state_ready, word(n_before - 1, 0));
    TEST_ASSERT_EQUAL_INT32(cam_state_fault, word(n_before, 0));
    TEST_ASSERT_EQUAL_INT32(0, word(n_before - 1, 7));
    TEST_ASSERT_EQUAL_INT32(CAM_FAULT_BIT(estop), word(n_before, 7));
}

static void test_a_later_fault_does_not_take_its_place(void)
{
    const uint32_t tick = fail();
    hal_host_fault_estop(false);
    go_on(20000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_reset(&rig.machine));
    go_on(100);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_ready));
    hal_host.in.inputs &= ~(uint32_t)hal_in_drive_ready;
    go_on(1000);
    TEST_ASSERT_EQUAL_INT(cam_state_fault, rig.last.want.state);
    expect_box(tick);
}

/// Neither a command nor time does, and it is handed over once.
static void test_nothing_takes_an_unread_box_but_a_release(void)
{
    cam_machine_t *m = &rig.machine;
    const uint32_t tick = fail();
    TEST_ASSERT_EQUAL_INT(cam_err_scope_unread, cam_machine_scope_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_unread, cam_machine_wave_begin(m, 4000));
    cam_machine_scope_stop(m);
    TEST_ASSERT_EQUAL_UINT32(14 + (n_before + n_behind) * n_signals, hal_host.slow.n_kept);
    hal_host.slow.n_kept = 0;
    scope()->last_tick -= (uint32_t)tick_hz * (cam_scope_patience_s + 1u);
    go_on(50);
    TEST_ASSERT_EQUAL_UINT32(0, hal_host.slow.n_kept);
    expect_box(tick);
    hal_host.slow.n_kept = 1;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(m));
    TEST_ASSERT_EQUAL_UINT32(0, hal_host.slow.n_kept);
    go_on(50);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope()->use);
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope()->phase); // the fault that is latched is not new
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(m));
}

static void test_a_restart_finds_the_box_again(void)
{
    const uint32_t tick = fail();
    static int32_t words[(n_before + n_behind) * n_signals];
    for (uint32_t i = 0; i < (n_before + n_behind) * n_signals; i++) {
        words[i] = word(i / n_signals, i % n_signals);
    }
    cam_machine_init(&rig.machine, &g_cam, tick_hz, hal_clock_hz());
    cam_machine_blackbox(&rig.machine);
    go_on(100);
    expect_box(tick);
    for (uint32_t i = 0; i < (n_before + n_behind) * n_signals; i++) {
        TEST_ASSERT_EQUAL_INT32(words[i], word(i / n_signals, i % n_signals));
    }
}

/// Record five rows by command, and let ten minutes pass, less `left` ticks, without anybody who
/// reads them.
static void record_and_wait(uint32_t left)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_set(scope(), cam_scope_field_rows, 5));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_on, cam_machine_wave_begin(&rig.machine, 4000));
    go_on(20);
    TEST_ASSERT_EQUAL_INT(cam_scope_done, scope()->phase);
    scope()->last_tick = rig.last.tick - tick_hz * (uint32_t)cam_scope_patience_s - 1u + left;
}

static void test_a_recording_has_precedence_until_it_is_released_or_forgotten(void)
{
    go_on(10);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope()->use);
    record_and_wait(11);
    go_on(5);
    TEST_ASSERT_EQUAL_INT(cam_scope_user, scope()->use);
    go_on(20);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope()->use);
}

/// Who records may stop it; the box is not theirs to stop.
static void test_a_recording_is_stopped_by_command(void)
{
    go_on(10);
    cam_machine_scope_stop(&rig.machine);
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope()->phase);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(&rig.machine));
    go_on(20);
    TEST_ASSERT_TRUE(cam_scope_is_on(scope()));
    cam_machine_scope_stop(&rig.machine);
    TEST_ASSERT_FALSE(cam_scope_is_on(scope()));
}

/// A recording is forgotten by nobody who is still at work: neither while a wave is played nor
/// while one is downloaded.
static void test_who_is_at_work_keeps_the_recording(void)
{
    cam_machine_t *m = &rig.machine;
    record_and_wait(0);
    m->identify.phase = cam_identify_runs;
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_scope_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_release(m));
    cam_machine_scope_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_scope_user, scope()->use);
    m->identify.phase = cam_identify_none;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, 4000)); // what is done is no obstacle
    scope()->use = cam_scope_user;
    scope()->phase = cam_scope_done;
    cam_machine_scope_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_scope_user, scope()->use);
    m->identify.is_open = false;
    cam_machine_scope_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope()->use);
}

/// Without enough memory nothing is recorded.
static void test_the_box_needs_memory(void)
{
    cam_machine_t *m = &rig.machine;
    const uint32_t n_words = scope()->n_words;
    scope()->n_words = 10;
    m->is_box_kept = true;
    cam_machine_scope_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_scope_idle, scope()->phase);
    TEST_ASSERT_TRUE(m->is_box_kept); // there is no other one
    scope()->n_words = n_words;
    cam_machine_scope_poll(m);
    TEST_ASSERT_EQUAL_INT(cam_scope_armed, scope()->phase);
    TEST_ASSERT_FALSE(m->is_box_kept);
}

/// One look takes a whole ring, even if no record was read for as long as that fills it but for the
/// record of a tick in progress.
static void test_a_full_ring_is_taken_at_once(void)
{
    go_on(10);
    for (uint32_t i = 0; i < cam_trace_capacity - 1; i++) {
        hal_host_tick();
    }
    const uint32_t before = scope()->ring.n_rows;
    cam_machine_scope_poll(&rig.machine);
    TEST_ASSERT_EQUAL_UINT32(before + cam_trace_capacity - 1u, scope()->ring.n_rows);
    TEST_ASSERT_FALSE(cam_trace_pop(&rig.machine.core->trace, &rig.last));
}

static void test_an_idle_recorder_leaves_the_ring_alone(void)
{
    rig.machine.has_box = false;
    hal_host_tick();
    cam_machine_scope_poll(&rig.machine);
    TEST_ASSERT_TRUE(cam_trace_pop(&rig.machine.core->trace, &rig.last));
}

/// A wave leaves the box what is behind it, and goes with the release.
static void test_a_wave_takes_its_share(void)
{
    cam_machine_t *m = &rig.machine;
    go_on(10);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, 4000));
    go_on(10);
    TEST_ASSERT_EQUAL_INT(cam_scope_box, scope()->use);
    TEST_ASSERT_EQUAL_UINT32(1000 + 14, scope()->at);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(m));
    go_on(10);
    TEST_ASSERT_EQUAL_UINT32(14, scope()->at);
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_end(m, 0));
}

/// In the memory of the STM32H743 the box holds every tick, and eight signals half a second beside
/// a wave of 0.9 s. Less memory makes rows far apart, never the time short.
static void test_the_time_fits_every_memory(void)
{
    enum { board_hz = 20000, half_s = board_hz / 2, behind = board_hz / 50 };
    static int32_t words[axi_words];
    cam_scope_t s;
    for (uint32_t n = 33; n < axi_words; n += n / 7u + 1u) {
        cam_scope_init(&s, (hal_memory_t){.words = words, .n_words = n}, board_hz);
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_blackbox_begin(&s, 0));
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(half_s, s.plan.before * s.plan.every);
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(behind,
                                            (s.ring.most_rows - s.plan.before) * s.plan.every);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(n, s.at + s.ring.most_rows * s.n_signals);
    }
    cam_scope_init(&s, (hal_memory_t){.words = words, .n_words = axi_words}, board_hz);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_blackbox_begin(&s, 0));
    TEST_ASSERT_EQUAL_UINT32(1, s.plan.every);
    cam_scope_reserve(&s, 18000);
    s.set.signals = 0xFF;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_scope_begin(&s, &s.set, cam_scope_user, 0, 0));
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(half_s, s.ring.most_rows);
    cam_scope_init(&s, (hal_memory_t){.words = words, .n_words = 31}, board_hz);
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory, cam_blackbox_begin(&s, 0));
}
