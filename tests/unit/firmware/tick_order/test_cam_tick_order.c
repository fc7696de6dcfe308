// SPDX-License-Identifier: Apache-2.0
// The order in which a tick calls the HAL, whose functions the linker wraps: reads come first, the
// force of U is written before anything else, everything is written once and as it is recorded.
#include "rig_bench.h"

enum { capacity = 64 };

static char calls[capacity]; ///< one letter per call: reads in lower case, writes in upper case
static uint32_t n_calls;
static uint32_t visited; ///< bit of a state
static int32_t most_force_q6;

static void note(char what)
{
    if (n_calls + 1u < capacity) {
        calls[n_calls++] = what;
    }
}

/// @return letter of an axis
static char of(hal_axis_t axis, char u)
{
    return (char)(u + (axis == hal_axis_x ? 3 : axis == hal_axis_z ? 5 : 0));
}

// NOLINTBEGIN(bugprone-reserved-identifier): the names are those of the linker
#define WRAP(type, name, letter, parameter, argument)                                              \
    type __real_##name(parameter);                                                                 \
    type __wrap_##name(parameter);                                                                 \
    type __wrap_##name(parameter)                                                                  \
    {                                                                                              \
        note(letter);                                                                              \
        return __real_##name(argument);                                                            \
    }
#define WRAP_WRITE(name, letter, parameters, ...)                                                  \
    void __real_##name parameters;                                                                 \
    void __wrap_##name parameters;                                                                 \
    void __wrap_##name parameters                                                                  \
    {                                                                                              \
        note(letter);                                                                              \
        __real_##name(__VA_ARGS__);                                                                \
    }
WRAP(uint32_t, hal_clock_isr, 'c', void, )
WRAP(int32_t, hal_axis_read_nm_isr, of(axis, 'u'), hal_axis_t axis, axis)
WRAP(int32_t, hal_swing_read_q32_isr, 's', void, )
WRAP(uint32_t, hal_inputs_read_isr, 'i', void, )
WRAP_WRITE(hal_encoder_read_isr, 'e', (hal_encoder_t * reading), reading)
WRAP_WRITE(hal_force_write_isr, 'F', (int32_t force_q6), force_q6)
WRAP_WRITE(hal_axis_write_isr, of(axis, 'U'), (hal_axis_t axis, const hal_setpoint_t *set), axis,
           set)
WRAP_WRITE(hal_swing_write_isr, 'W', (const hal_swing_t *set), set)
WRAP_WRITE(hal_spindle_write_isr, 'S', (int32_t speed_mrpm), speed_mrpm)
WRAP_WRITE(hal_outputs_write_isr, 'O', (uint32_t bits), bits)
// NOLINTEND(bugprone-reserved-identifier)

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
    static const char each[] = "ceuxzsiUXZSO";
    const bool takes_force = hal_host.slow.force.quantum_un > 0u;
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(takes_force ? 1 : 0, times('F'), calls);
    uint32_t n_reads = 0;
    while (n_reads < n_calls && calls[n_reads] >= 'a') {
        n_reads++;
    }
    TEST_ASSERT_TRUE_MESSAGE(!takes_force || calls[n_reads] == 'F', calls); // before all else
    for (uint32_t i = n_reads; i < n_calls; i++) {
        TEST_ASSERT_TRUE_MESSAGE(calls[i] < 'a', calls);
    }
    for (uint32_t i = 0; i + 1u < sizeof each; i++) {
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(1, times(each[i]), calls);
    }
    TEST_ASSERT_EQUAL_CHAR_MESSAGE('c', calls[0], calls); // the time stamp is that of the tick
}

/// The interrupt, after which one record is published: what the tick has read and written.
static void expect_tick(void)
{
    cam_tick_record_t r;
    n_calls = 0;
    memset(calls, 0, sizeof calls);
    cam_isr();
    expect_order();
    TEST_ASSERT_TRUE(cam_trace_pop(&g_cam.trace, &r));
    TEST_ASSERT_FALSE(cam_trace_pop(&g_cam.trace, &(cam_tick_record_t){0}));
    TEST_ASSERT_EQUAL_MEMORY(r.out, hal_host.out.axis, sizeof r.out);
    TEST_ASSERT_EQUAL_HEX32(r.want.outputs, hal_host.out.outputs);
    TEST_ASSERT_EQUAL_INT32(r.force_q6, hal_host.out.force_q6);
    TEST_ASSERT_EQUAL_INT32(r.want.spindle_mrpm, hal_host.out.spindle_mrpm);
    TEST_ASSERT_EQUAL_UINT32(hal_host.clock, r.in.clock);
    TEST_ASSERT_EQUAL_UINT32(hal_host.in.read.counts, r.in.encoder.counts);
    visited |= UINT32_C(1) << (uint32_t)r.want.state;
    most_force_q6 = r.force_q6 > most_force_q6 ? r.force_q6 : most_force_q6;
}

/// Cut a part and stop, each tick judged.
static void cut(void)
{
    visited = 0;
    most_force_q6 = 0;
    rig.isr = expect_tick;
    fixture_rig_tick(&rig);
    TEST_ASSERT_TRUE(fixture_rig_bring(&rig, cam_state_cutting));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_ready, 60000));
    hal_host_fault_estop(true);
    fixture_rig_ticks(&rig, 10);
    TEST_ASSERT_EQUAL_HEX32((2u << cam_state_fault) - 1u, visited);
}

static void test_tick_reads_before_it_writes_and_writes_all_once_in_every_state(void)
{
    cut();
}

/// The axes of the rig need no force, so the loop is a weak one. With enabled drives alone its
/// force may be limited as U presses on its stop.
static void test_force_leaves_before_all_other_writes(void)
{
    hal_host.slow.force.quantum_un = 20000;
    set(cam_param_servo_integral_mHz, 0);
    set(cam_param_servo_pole_hz, 100);
    TEST_ASSERT_EQUAL_INT(cam_err_servo_none, cam_machine_enable(&rig.machine));
    set(cam_param_servo_crossover_hz, 1);
    cut();
    TEST_ASSERT_NOT_EQUAL_INT32(0, most_force_q6);
    for (uint32_t is_lost = 0; is_lost < 2u; is_lost++) {
        g_cam.motion.u_press_q6 = 640;
        hal_host_fault_drive(is_lost != 0u);
        fixture_rig_ticks(&rig, 2);
        TEST_ASSERT_EQUAL_INT32(is_lost != 0u ? 0 : 640, g_cam.force.servo.most_q6);
        TEST_ASSERT_EQUAL_INT32(is_lost != 0u ? 0 : 640, g_cam.motion.u_press_q6);
    }
}
