// SPDX-License-Identifier: Apache-2.0
// Sessions of random commands over CAN and random faults: whatever comes in whatever order, no axis
// jumps, moves beyond its limits, without enable, or by hand without a living master.
#include "fixture_can.h"
#include "fixture_random.h"
#include "hal_host.h"
#include "unity.h"
#include <stdio.h>  // snprintf
#include <stdlib.h> // labs

enum { tick_hz = 20000, mm = 1000000, n_sessions = 15, session_ticks = 40000 };
enum { patience_ticks = tick_hz / 4, brake_ticks = 3000 };

static fixture_can_t f;
static fixture_part_t part;
static fixture_random_t dice;
static uint32_t session;
static uint32_t n_visits[cam_n_states];

/// What the last tick has shown.
static struct {
    cam_state_t state;
    bool is_enabled;
    int32_t pos_nm[hal_n_axes];
    int32_t step_nm[hal_n_axes];
    uint32_t n_steps;  ///< ticks since the enable
    uint32_t alive_at; ///< [tick] of the last command
    int32_t home_nm;   ///< [nm] U's number where the port counts 0, in the tick to come
} last;

void setUp(void)
{
    part = fixture_part_short();
    fixture_can_init(&f, &part, tick_hz);
    fixture_can_start(&f);
}

static int64_t any(int64_t low, int64_t high)
{
    return fixture_random_range(&dice, low, high);
}

/// @return a value that people, or a hand that slips, give a parameter
static int32_t any_value(cam_param_id_t id)
{
    const cam_param_info_t *info = cam_param_info(id);
    const int64_t kind = any(0, 7);
    if (kind == 0) {
        return (int32_t)any(INT32_MIN, INT32_MAX);
    }
    if (kind == 1) {
        return any(0, 1) != 0 ? info->max : info->min;
    }
    const int64_t wide = ((int64_t)info->max - info->min) / 64 + 1;
    const int64_t span = wide < INT64_C(2) * mm ? wide : INT64_C(2) * mm;
    const int64_t near = info->def + any(-span, span);
    return (int32_t)(near < info->min ? info->min : near > info->max ? info->max : near);
}

/// Parameters that an operator changes; those of the machine itself stay, so that the limits below
/// hold throughout.
static cam_param_id_t any_param(void)
{
    static const cam_param_id_t ids[] = {
        cam_param_x_trim_nm,
        cam_param_feed_override_ppm,
        cam_param_spindle_override_ppm,
        cam_param_phase_udeg,
        cam_param_amplitude_ppm,
        cam_param_x_datum_nm,
        cam_param_z_datum_nm,
        cam_param_tool,
        cam_param_tool_1_x_nm,
        cam_param_tool_2_z_nm,
        cam_param_spindle_mrpm,
        cam_param_feed_nm,
        cam_param_rehearse_turns,
        cam_param_homing_required,
        cam_param_u_home,
        cam_param_x_home,
        cam_param_z_home,
        cam_param_x_jog_um_per_s,
        cam_param_u_home_nm,
        cam_param_switch_1_per_turn,
        cam_param_switch_3_per_turn,
        cam_param_x_home_nm,
        cam_param_x_home_travel_nm,
    };
    return ids[any(0, (int64_t)(sizeof ids / sizeof ids[0]) - 1)];
}

enum {
    enable = 1,
    disable,
    start,
    stop,
    reset,
    set_parameter,
    select_table = 8,
    home = 15,
    manual = 30,
    jog,
    step,
    home_axis,
    zero_x,
    zero_z,
    hold = 40,
    resume,
    stage = 51,
    most_command = 59,
};

/// @return the command that a good operator gives most often in a state
static uint8_t usual_command(cam_state_t state)
{
    switch (state) {
    case cam_state_off:
        return any(0, 1) != 0 ? enable : manual;
    case cam_state_ready:
        return start;
    case cam_state_manual:
        return any(0, 3) == 0 ? home_axis : any(0, 5) == 0 ? disable : jog;
    case cam_state_cutting:
        return any(0, 3) == 0 ? hold : set_parameter;
    case cam_state_holding:
        return resume;
    case cam_state_fault:
        return reset;
    case cam_state_homing:
    case cam_state_engaging:
    case cam_state_disengaging:
    case cam_state_rehearsing:
    case cam_state_identifying:
    case cam_n_states:
        break;
    }
    return set_parameter;
}

static void command(void)
{
    const uint8_t what = any(0, 2) != 0 ? usual_command(last.state) : (uint8_t)any(1, most_command);
    const cam_param_id_t id = any_param();
    const bool is_param = what == set_parameter || what == stage;
    const int32_t by_hand =
        (int32_t)(what == jog ? any(-12000, 12000) : any(INT64_C(-3) * mm, INT64_C(3) * mm));
    const int32_t value = is_param          ? any_value(id)
                          : what == zero_x  ? (int32_t)any(INT64_C(80) * mm, INT64_C(100) * mm)
                          : any(0, 15) == 0 ? (int32_t)any(INT32_MIN, INT32_MAX)
                                            : by_hand;
    fixture_can_receive(0x640, 8, what, (uint8_t)(is_param ? (int64_t)id : any(0, 3)), value);
    last.alive_at = hal_host.n_ticks & UINT32_MAX;
}

/// Something breaks, or is mended.
static void fault(void)
{
    switch (any(0, 7)) {
    case 0:
        hal_host_fault_estop(true);
        break;
    case 1:
        hal_host_fault_drive(true);
        break;
    case 2:
        hal_host_fault_bus(true);
        break;
    case 3:
        hal_host_fault_late((uint32_t)any(1, 100));
        break;
    case 4:
        hal_host_fault_counts((int32_t)any(-300, 300));
        break;
    default:
        hal_host_fault_estop(false);
        hal_host_fault_drive(false);
        hal_host_fault_bus(false);
        break;
    }
}

static void expect(bool is_good, const char *what)
{
    if (!is_good) { // every tick has dozens of them
        char text[160];
        (void)snprintf(text, sizeof text, "session %u, tick %u, state %s: %s", (unsigned)session,
                       (unsigned)hal_host.n_ticks, cam_state_name(last.state), what);
        TEST_FAIL_MESSAGE(text);
    }
}

/// @return whether one state may follow another
static bool may_follow(cam_state_t to, cam_state_t from)
{
    static const uint32_t from_to[cam_n_states] = {
        [cam_state_off] = 1u << cam_state_homing | 1u << cam_state_manual,
        [cam_state_homing] = 1u << cam_state_ready | 1u << cam_state_off,
        [cam_state_ready] = 1u << cam_state_engaging | 1u << cam_state_rehearsing |
                            1u << cam_state_identifying | 1u << cam_state_off,
        [cam_state_engaging] = 1u << cam_state_cutting | 1u << cam_state_holding |
                               1u << cam_state_disengaging | 1u << cam_state_ready,
        [cam_state_cutting] = 1u << cam_state_holding | 1u << cam_state_disengaging,
        [cam_state_holding] = 1u << cam_state_cutting | 1u << cam_state_disengaging,
        [cam_state_disengaging] = 1u << cam_state_ready,
        [cam_state_fault] = 1u << cam_state_off,
        [cam_state_rehearsing] = 1u << cam_state_engaging | 1u << cam_state_ready,
        [cam_state_identifying] = 1u << cam_state_ready | 1u << cam_state_off,
        [cam_state_manual] = 1u << cam_state_off,
    };
    const bool is_fault = to == cam_state_fault && from != cam_state_off;
    return to == from || is_fault || (from_to[from] >> to & 1u) != 0u;
}

/// @return [nm per tick] of a speed, with what is rounded and what the encoder's counts shake
static int32_t most_step_nm(int32_t um_per_s)
{
    return um_per_s / (tick_hz / 1000) * 17 / 16 + 30;
}

/// @return [nm per tick] by which a speed may change in a plan
static int32_t most_change_nm(int32_t mm_per_s2)
{
    const int64_t per_plan = (int64_t)mm_per_s2 * mm / tick_hz * cam_plan_ticks(tick_hz) / tick_hz;
    return (int32_t)(per_plan * 17 / 16) + 60;
}

/// @return [nm] set-point of an axis by the port; that of U before its feed-forward
static int32_t set_nm(uint32_t axis)
{
    return axis == (uint32_t)hal_axis_u ? (f.rig.last.want.u_set_q6 >> 6) - last.home_nm
                                        : hal_host.out.axis[axis].pos_nm;
}

static void check_axes(const cam_params_t *p, bool is_enabled)
{
    const int32_t speeds[] = {p->u_speed_um_per_s, p->x_speed_um_per_s, p->z_speed_um_per_s};
    const int32_t accelerations[] = {p->u_acceleration_mm_per_s2, p->x_acceleration_mm_per_s2,
                                     p->z_acceleration_mm_per_s2};
    const bool is_moving = is_enabled && last.is_enabled;
    last.n_steps = is_moving ? last.n_steps + 1u : 0u;
    const bool is_alone =
        last.state == cam_state_manual &&
        (uint32_t)hal_host.n_ticks - last.alive_at > (uint32_t)patience_ticks + brake_ticks;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int32_t step_nm = set_nm(i) - last.pos_nm[i];
        const int32_t change_nm = step_nm - last.step_nm[i];
        if (is_moving) {
            expect(labs(step_nm) <= most_step_nm(speeds[i]), "an axis is too fast");
            expect(!is_alone || step_nm == 0, "an axis moves without a master");
        }
        if (last.n_steps > 1u) {
            expect(labs(change_nm) <= most_change_nm(accelerations[i]), "an axis jerks");
        }
        last.pos_nm[i] += step_nm;
        last.step_nm[i] = step_nm;
    }
}

static void check(void)
{

    const cam_params_t *p = &f.rig.machine.params;
    const cam_want_t *want = &f.rig.last.want;
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    const uint32_t own = CAM_FAULT_BIT(setpoint_speed) | CAM_FAULT_BIT(setpoint_acceleration) |
                         CAM_FAULT_BIT(setpoint_range) | CAM_FAULT_BIT(following_error);
    const bool is_still = want->state == cam_state_off || want->state == cam_state_manual ||
                          want->state == cam_state_fault;
    expect(may_follow(want->state, last.state), cam_state_name(want->state));
    expect(!is_enabled || want->state != cam_state_off, "enabled in off");
    expect(!is_still || hal_host.out.spindle_mrpm == 0, "the spindle turns");
    expect(labs(hal_host.out.spindle_mrpm) <= p->spindle_limit_mrpm, "the spindle is too fast");
    expect((want->faults & own) == 0u, "a set-point that the guard refuses");
    last.state = want->state;
    check_axes(p, is_enabled);
    if (want->state != cam_state_fault && cam_state_is_in_work(want->state)) {
        const int32_t x_nm = hal_host.out.axis[hal_axis_x].pos_nm +
                             cam_offsets_shift_nm(&f.rig.machine.offsets, p, hal_axis_x);
        const bool has_limits = p->x_low_nm < p->x_high_nm; // the defaults have none
        const int32_t step_nm = last.step_nm[hal_axis_x];   // a fault may have left X outside
        const bool goes_out = x_nm < p->x_low_nm ? step_nm < 0 : x_nm > p->x_high_nm && step_nm > 0;
        expect(!has_limits || !goes_out, "X leaves its travel");
    }
    last.is_enabled = is_enabled;
    last.home_nm = g_cam.motion.u_home_nm;
    n_visits[want->state]++;
}

static void play_session(void)
{
    setUp();
    dice.state = 77u + session;
    last.state = cam_state_off;
    last.is_enabled = false;
    last.home_nm = 0;
    hal_host.in.axis_nm[hal_axis_x] = 47 * mm; // near the part, so that sessions come to cut it
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        f.rig.lathe.home[i] = (ideal_home_t){.side = any(0, 1) != 0 ? 1 : -1,
                                         .edge_nm = (int32_t)any(-300000, 300000),
                                         .pitch_nm = 200000};
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_x_high_nm, 50 * mm));
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, cam_param_x_low_nm, 45900000));
    TEST_ASSERT_EQUAL_INT(
        cam_ok, fixture_rig_set(&f.rig, cam_param_rehearse_turns, (int32_t)any(0, 1) * 3));
    uint32_t pause = 0;
    for (uint32_t i = 0; i < session_ticks; i++) {
        if (pause == 0u) {
            command();
            pause = (uint32_t)(any(0, 9) == 0 ? any(0, 9000) : any(1, 600));
        }
        pause--;
        if (any(0, 12000) == 0) {
            fault();
        }
        fixture_can_tick(&f, i);
        check();
    }
}

static void test_any_session_keeps_every_limit(void)
{
    for (session = 0; session < n_sessions; session++) {
        play_session();
    }
    for (uint32_t i = 0; i < cam_n_states; i++) {
        if (i != cam_state_identifying) { // it needs the blocks of a wave
            TEST_ASSERT_GREATER_THAN_UINT32_MESSAGE(0, n_visits[i], cam_state_name((cam_state_t)i));
        }
    }
}
