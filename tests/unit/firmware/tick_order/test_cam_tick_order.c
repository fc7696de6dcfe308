// SPDX-License-Identifier: Apache-2.0
// A port of its own that writes down who calls it: reads come first, everything is written once.
#include "cam_machine.h"
#include "fixture_image.h"
#include "unity.h"
#include <stdlib.h>
#include <string.h>

enum { capacity = 64 };

static char calls[capacity]; ///< one letter per call: reads in lower case, writes in upper case
static uint32_t n_calls;
static uint32_t now_clocks;
static hal_encoder_t encoder;
static hal_setpoint_t written[hal_n_axes];
static uint32_t outputs;
static bool takes_force;
static int32_t force_q6, most_force_q6;
static int32_t spindle_mrpm;
static cam_t core;
static cam_machine_t machine;
static fixture_image_t image;

static void note(char what)
{
    if (n_calls + 1u < capacity) {
        calls[n_calls++] = what;
    }
}

uint32_t hal_clock_isr(void)
{
    note('c');
    return now_clocks;
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    note('e');
    *reading = encoder;
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    note((char)('u' + (axis == hal_axis_x ? 3 : axis == hal_axis_z ? 5 : 0)));
    return written[axis].pos_nm;
}

int32_t hal_swing_read_q32_isr(void)
{
    note('s');
    return 0;
}

hal_memory_t hal_scope_memory(void)
{
    return (hal_memory_t){0};
}

void hal_scope_keep(const int32_t *words, uint32_t n)
{
    (void)words;
    (void)n;
}

bool hal_has_swing(void)
{
    return true;
}

bool hal_has_edge_time(void)
{
    return false;
}

hal_trust_t hal_trust(void)
{
    return (hal_trust_t){0};
}

bool hal_measures_u(void)
{
    return false;
}

hal_params_t hal_params_kept(void)
{
    return (hal_params_t){0};
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    (void)bytes;
    (void)size;
    return false;
}

hal_operator_t hal_operator(void)
{
    return (hal_operator_t){.is_acknowledge_waived = true};
}

hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    (void)axis;
    return (hal_axis_scale_t){0};
}

hal_force_t hal_force(void)
{
    return (hal_force_t){.quantum_un = takes_force ? 20000u : 0u};
}

void hal_force_write_isr(int32_t wanted_q6)
{
    note('F');
    force_q6 = wanted_q6;
    most_force_q6 = wanted_q6 > most_force_q6 ? wanted_q6 : most_force_q6;
}

void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    (void)setpoint;
    note('W');
}

uint32_t hal_inputs_read_isr(void)
{
    note('i');
    return hal_in_drive_ready;
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    note((char)('U' + (axis == hal_axis_x ? 3 : axis == hal_axis_z ? 5 : 0)));
    written[axis] = *setpoint;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    note('S');
    spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    note('O');
    outputs = bits;
}

_Noreturn void hal_halt(const char *why)
{
    TEST_MESSAGE(why);
    abort();
}

static void start(void)
{
    const fixture_part_t part = fixture_part_short();
    memset(written, 0, sizeof written);
    written[hal_axis_x].pos_nm = 46500000; // not far from the work
    encoder = (hal_encoder_t){.counts = 77u};
    now_clocks = 0;
    cam_machine_init(&machine, &core, 20000, 200000000);
    cam_tick_isr(&core);
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_select_table(&machine, image.bytes, image.size));
}

void setUp(void)
{
    takes_force = false;
    force_q6 = 0;
    most_force_q6 = 0;
    start();
}

/// One tick; counts of the spindle in the tick at 2500 r/min: 20.8.
static void tick(uint32_t counts)
{
    n_calls = 0;
    memset(calls, 0, sizeof calls);
    now_clocks += 10000u;
    encoder.counts += counts;
    if (encoder.counts - encoder.index_counts >= 10000u) {
        encoder.index_counts += 10000u;
        encoder.n_index++;
    }
    cam_tick_isr(&core);
}

static uint32_t times(char what)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < n_calls; i++) {
        n += calls[i] == what ? 1u : 0u;
    }
    return n;
}

static void expect_order(void)
{
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(takes_force ? 1 : 0, times('F'), calls);
    uint32_t n_reads = 0;
    while (n_reads < n_calls && calls[n_reads] >= 'a') {
        n_reads++;
    }
    TEST_ASSERT_TRUE_MESSAGE(!takes_force || calls[n_reads] == 'F', calls); // before all else
    for (uint32_t i = n_reads; i < n_calls; i++) {
        TEST_ASSERT_TRUE_MESSAGE(calls[i] < 'a', calls);
    }
    static const char each[] = "ceuxzsiUXZSO";
    for (uint32_t i = 0; i + 1u < sizeof each; i++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, times(each[i]), calls);
    }
    TEST_ASSERT_EQUAL_CHAR_MESSAGE('c', calls[0], calls); // the time stamp is that of the tick
}

static void test_tick_reads_before_it_writes_and_writes_all_once_in_every_state(void)
{
    bool is_seen[cam_n_states] = {false};
    for (uint32_t i = 0; i < 40000u; i++) {
        const cam_state_t state = cam_machine_status(&machine).state;
        is_seen[state] = true;
        if (state == cam_state_off && !is_seen[cam_state_fault]) {
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&machine));
        } else if (state == cam_state_ready && !is_seen[cam_state_disengaging]) {
            TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&machine));
        }
        const bool is_jump = state == cam_state_ready && is_seen[cam_state_disengaging];
        tick(is_jump ? 900u : 20u + (i % 6u != 0u ? 1u : 0u));
        expect_order();
    }
    for (uint32_t state = 0; state <= cam_state_fault; state++) {
        TEST_ASSERT_TRUE_MESSAGE(is_seen[state], cam_state_name((cam_state_t)state));
    }
}

static void test_tick_writes_what_it_records_and_publishes(void)
{
    cam_tick_record_t r;
    while (cam_trace_pop(&core.trace, &r)) {
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_enable(&machine));
    for (uint32_t i = 0; i < 3000u; i++) {
        tick(21u);
        TEST_ASSERT_TRUE(cam_trace_pop(&core.trace, &r));
        TEST_ASSERT_FALSE(cam_trace_pop(&core.trace, &(cam_tick_record_t){0}));
        TEST_ASSERT_EQUAL_MEMORY(r.out, written, sizeof written);
        TEST_ASSERT_EQUAL_HEX32(r.want.outputs, outputs);
        TEST_ASSERT_EQUAL_INT32(r.force_q6, force_q6);
        TEST_ASSERT_EQUAL_INT32(r.want.spindle_mrpm, spindle_mrpm);
        TEST_ASSERT_EQUAL_UINT32(now_clocks, r.in.clock);
        TEST_ASSERT_EQUAL_UINT32(encoder.counts, r.in.encoder.counts);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_ready, cam_machine_status(&machine).state);
}

static void test_force_leaves_before_all_other_writes(void)
{
    takes_force = true;
    start();
    tick(21u);
    TEST_ASSERT_EQUAL_INT(cam_err_servo_none, cam_machine_enable(&machine));
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_machine_set_param(&machine, cam_param_servo_crossover_hz, 300));
    tick(21u);
    test_tick_writes_what_it_records_and_publishes();
    TEST_ASSERT_NOT_EQUAL_INT32(0, most_force_q6);
    expect_order();
}
