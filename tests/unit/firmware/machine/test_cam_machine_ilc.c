// SPDX-License-Identifier: Apache-2.0
// Learning as the slow side of the machine sees it: which values it takes back, when it works.
#include "cam_machine.h"
#include "cam_machine_inner.h" // cam_machine_offer_copy
#include "rig_bench.h"

enum { tick_us = 50, one_q16 = 65536, spare_ticks = 4, spare_ticks2 = 16 };

static cam_err_t set_learned(uint32_t index, int32_t value)
{
    return cam_machine_set_learned(&rig.machine, index, value);
}

static int32_t learned(uint32_t index)
{
    int32_t value = -1;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_get_learned(&rig.machine, index, &value));
    return value;
}

/// What was learned of one machine is set where nothing cuts; elsewhere it is refused unchanged.
static void test_learned_values_are_set_in_off_and_ready_only(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, 1234));
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, 5678));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(&rig.machine));
    TEST_ASSERT_LESS_THAN_UINT32(60000, fixture_rig_until(&rig, cam_state_cutting, 60000));
    TEST_ASSERT_EQUAL_INT(cam_err_param_state, set_learned(cam_ilc_value_phase, 9));
    TEST_ASSERT_EQUAL_INT32(5678, learned(cam_ilc_value_phase));
    TEST_ASSERT_EQUAL_INT(cam_err_param_id, set_learned(cam_ilc_n_values, 0));
    int32_t value = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_param_id,
                          cam_machine_get_learned(&rig.machine, cam_ilc_n_values, &value));
}

/// A drive's constant goes as far as learning itself could lead it, in both senses; the limit of
/// one does not hold for another value.
static void test_constants_of_the_drive_stay_within_what_can_be_learned(void)
{
    const cam_params_t *p = &rig.machine.params;
    const int64_t k1_ticks_q16 = (int64_t)p->k1_ns * one_q16 / (tick_us * 1000);
    const int64_t lead_q16 = (int64_t)p->lead_ns * one_q16 / (tick_us * 1000);
    const int64_t k2_ticks2_q16 = (int64_t)p->k2_us2 * one_q16 / (tick_us * tick_us);
    const int32_t k1_most = (int32_t)(k1_ticks_q16 + lead_q16 + spare_ticks * one_q16);
    const int32_t k2_most = (int32_t)(k2_ticks2_q16 + spare_ticks2 * one_q16);
    const uint32_t index[] = {cam_ilc_value_k1, cam_ilc_value_k2};
    const int32_t most[] = {k1_most, k2_most};
    for (int i = 0; i < 2; i++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(index[i], sign * (most[i] - 64)));
            TEST_ASSERT_EQUAL_INT(cam_err_param_range,
                                  set_learned(index[i], sign * (most[i] + 64)));
            TEST_ASSERT_EQUAL_INT32(sign * (most[i] - 64), learned(index[i]));
        }
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, INT32_MAX));
}

/// Each kind of value has a range of its own; what is beyond leaves the old one.
static void test_values_beyond_their_range_leave_the_old_ones(void)
{
    static const struct {
        uint32_t index;
        int32_t good, bad[2];
    } cases[] = {
        {cam_ilc_value_speed, 1 << 26, {(1 << 26) + 1, -1}},
        {cam_ilc_value_masked, 5, {1 << 29, INT32_MIN}},
        {cam_ilc_value_correction, cam_ilc_most_nm * 64, {cam_ilc_most_nm * 64 + 1, INT32_MIN}},
        {cam_ilc_value_gain + 1, INT16_MIN, {INT16_MIN - 1, INT16_MAX + 1}},
        {cam_ilc_value_ripple, cam_ripple_most, {cam_ripple_most + 1, INT32_MAX}},
    };
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cases[i].index, cases[i].good));
        for (int k = 0; k < 2; k++) {
            TEST_ASSERT_EQUAL_INT(cam_err_param_range,
                                  set_learned(cases[i].index, cases[i].bad[k]));
            TEST_ASSERT_EQUAL_INT32(cases[i].good, learned(cases[i].index));
        }
    }
}

/// A constant of the drive or a delay that is set anew ends what was learned on top of it; another
/// parameter does not.
static void test_new_constants_of_the_drive_forget_what_was_learned(void)
{
    static const cam_param_id_t drive[] = {cam_param_k1_ns, cam_param_k2_us2, cam_param_lead_ns,
                                           cam_param_u_scale_latency_ns};
    for (uint32_t i = 0; i < sizeof drive / sizeof drive[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 1000));
        cam_machine_unlearn(&rig.machine, cam_param_feed_nm);
        TEST_ASSERT_EQUAL_INT32(1000, learned(cam_ilc_value_k1));
        cam_machine_unlearn(&rig.machine, drive[i]);
        TEST_ASSERT_EQUAL_INT32(0, learned(cam_ilc_value_k1));
    }
}

/// What the encoder's error depends on makes the ripple walk, and nothing else does.
static void test_the_encoders_error_is_led_to_its_new_value(void)
{
    static const cam_param_id_t ripple[] = {cam_param_eccentricity_nturn,
                                            cam_param_eccentricity_udeg, cam_param_ripple_turns};
    for (uint32_t i = 0; i < sizeof ripple / sizeof ripple[0]; i++) {
        rig.machine.ilc.blending = 0;
        cam_machine_unlearn(&rig.machine, cam_param_feed_nm);
        TEST_ASSERT_EQUAL_HEX8(0, rig.machine.ilc.blending);
        cam_machine_unlearn(&rig.machine, ripple[i]);
        TEST_ASSERT_EQUAL_HEX8(cam_ilc_blend_ripple, rig.machine.ilc.blending);
    }
}

static uint32_t generations(uint32_t n_polls)
{
    const uint32_t before = rig.machine.generation;
    for (uint32_t i = 0; i < n_polls; i++) {
        cam_machine_ilc_poll(&rig.machine, cam_state_ready,
                             !cam_machine_status(&rig.machine).is_u_at_rest);
        fixture_rig_ticks(&rig, 2);
    }
    return rig.machine.generation - before;
}

/// Without learning there is nothing to hand over. A value that is set is walked to, one new
/// configuration for each step that changes something, and none when it is reached.
static void test_only_what_changes_is_handed_over(void)
{
    set(cam_param_learn_harmonics, 0);
    set(cam_param_ripple_turns, 0);
    bring(cam_state_ready);
    (void)generations(400);
    TEST_ASSERT_EQUAL_HEX8(0, rig.machine.ilc.blending);
    TEST_ASSERT_EQUAL_UINT32(0, generations(10));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 640));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
    const cam_config_t *last = atomic_load(&rig.machine.core->config.offered);
    TEST_ASSERT_EQUAL_INT32(640, last->learned.k1_q16);
    TEST_ASSERT_EQUAL_UINT32(0, generations(100));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k2, -320));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
    TEST_ASSERT_EQUAL_INT32(-320, atomic_load(&rig.machine.core->config.offered)->learned.k2_q16);
}

/// A correction of U and a ripple of the spindle alone are handed over, too, without the constants.
static void test_a_correction_and_a_ripple_are_handed_over(void)
{
    set(cam_param_learn_harmonics, 8);
    set(cam_param_ripple_turns, 64);
    bring(cam_state_ready);
    (void)generations(400);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_speed, 1 << 20));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_correction, 64 * 64));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(4000));
    const cam_learned_t *in = &atomic_load(&rig.machine.core->config.offered)->learned;
    TEST_ASSERT_NOT_EQUAL_INT16(0, in->c[0]);
    TEST_ASSERT_EQUAL_INT16(0, in->dm[1]);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_ripple + 2, 300));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(4000));
    in = &atomic_load(&rig.machine.core->config.offered)->learned;
    TEST_ASSERT_NOT_EQUAL_INT16(0, in->dm[1]);
}

/// Each of the three reasons to work suffices: learning of U, of the ripple, a walk not yet ended.
static void test_each_reason_to_work_suffices(void)
{
    static const struct {
        int32_t harmonics, turns;
        uint8_t blending;
        bool works;
    } cases[] = {
        {0, 0, 0, false}, {4, 0, 0, true}, {0, 4, 0, true}, {0, 0, cam_ilc_blend_drive, true}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        set(cam_param_learn_harmonics, cases[i].harmonics);
        set(cam_param_ripple_turns, cases[i].turns);
        rig.machine.ilc.blending = cases[i].blending;
        rig.machine.ilc.state = cam_state_off;
        cam_machine_ilc_poll(&rig.machine, cam_state_ready,
                             !cam_machine_status(&rig.machine).is_u_at_rest);
        TEST_ASSERT_EQUAL_UINT8(cases[i].works ? cam_state_ready : cam_state_off,
                                rig.machine.ilc.state);
        fixture_rig_ticks(&rig, 2);
    }
}

/// While the interrupt has not taken the last configuration, the walk waits for it.
static void test_walk_waits_for_the_interrupt(void)
{
    bring(cam_state_ready);
    (void)generations(400);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 640));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(&rig.machine, cam_param_trace_on, 1));
    const uint32_t before = rig.machine.generation;
    for (int i = 0; i < 100; i++) {
        cam_machine_ilc_poll(&rig.machine, cam_state_ready,
                             !cam_machine_status(&rig.machine).is_u_at_rest);
    }
    TEST_ASSERT_EQUAL_UINT32(before, rig.machine.generation);
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
}

/// What is not learned is told with its reason: the first one that holds, in this order.
static void test_why_nothing_is_learned_is_told(void)
{
    cam_machine_t *m = &rig.machine;
    m->params.learn_harmonics = 0;
    TEST_ASSERT_EQUAL_INT(cam_ilc_not_asked, cam_machine_learning(m).reason);
    m->params.learn_harmonics = 8;
    TEST_ASSERT_EQUAL_INT(cam_ilc_not_measured, cam_machine_learning(m).reason);
    hal_host.slow.measures_u = true;
    TEST_ASSERT_EQUAL_INT(cam_ilc_all, cam_machine_learning(m).reason);
    m->table.n_lobes = 2;
    TEST_ASSERT_EQUAL_INT(cam_ilc_lobes, cam_machine_learning(m).reason);
    m->table.speed = m->table.u;
    TEST_ASSERT_EQUAL_INT(cam_ilc_modulated, cam_machine_learning(m).reason);
    m->has_table = false;
    TEST_ASSERT_EQUAL_INT(cam_ilc_no_table, cam_machine_learning(m).reason);
}

/// A ripple alone, of the spindle and none of U, is something new, too.
static void test_what_the_encoder_measures_alone_is_handed_over(void)
{
    set(cam_param_ripple_turns, 4);
    bring(cam_state_ready);
    (void)generations(400);
    TEST_ASSERT_EQUAL_UINT32(0, generations(10));
    cam_config_t *copy = cam_config_copy(&rig.machine.core->config);
    copy->learned.dm[1]++; // as an eccentricity would that U does not follow
    cam_machine_offer_copy(&rig.machine);
    fixture_rig_ticks(&rig, 2);
    rig.machine.ilc.blending = cam_ilc_blend_ripple;
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(400));
    TEST_ASSERT_EQUAL_INT16(0, atomic_load(&rig.machine.core->config.offered)->learned.dm[1]);
}

/// A harmonic is told as far as there is one.
static void test_harmonics_are_told(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_correction, 64 * 64));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_masked, 4));
    TEST_ASSERT_EQUAL_INT32(64 * 64, cam_ilc_harmonic(&rig.machine.ilc, 0).correction_q6.re);
    TEST_ASSERT_FALSE(cam_ilc_harmonic(&rig.machine.ilc, 1).is_masked);
    TEST_ASSERT_TRUE(cam_ilc_harmonic(&rig.machine.ilc, 2).is_masked);
    const cam_ilc_harmonic_t beyond = cam_ilc_harmonic(&rig.machine.ilc, cam_ilc_terms);
    TEST_ASSERT_EQUAL_INT32(0, beyond.correction_q6.re);
    TEST_ASSERT_FALSE(beyond.is_masked);
}

/// Turns of 1000 ticks in a rehearsal, of which nothing but the gather knows.
/// @return [nm / 64] what the scale cannot tell, of the last turn that counted
static uint32_t floor_of(int32_t scale_nm)
{
    enum { n_ticks = 1000, plan_ticks = 8, n_turns = 12 };
    setUp();
    hal_host.slow.measures_u = true;
    set(cam_param_learn_harmonics, 4);
    set(cam_param_u_scale_nm, scale_nm);
    cam_turn_bins_t *g = &rig.machine.core->bins;
    cam_tick_record_t record = {.config = rig.machine.generation,
                                .in.actual_nm = {-300},
                                .want = {.state = cam_state_rehearsing, .u_due_q6 = -64 * 300}};
    const cam_motion_t motion = {.is_playing = true, .scale_q30 = 1 << 30};
    const int32_t step_q32 = (int32_t)(INT64_C(4294967296) / n_ticks) + 1;
    for (int i = 1; i < n_ticks * n_turns; i++) {
        const int64_t pos_q32 = (int64_t)i * step_q32;
        record.angle.pos_q32 = pos_q32;
        record.angle.measured_q32 = (uint32_t)(uint64_t)pos_q32;
        cam_turn_bins_add_isr(g, &record);
        if (i % plan_ticks == 0) {
            record.angle.speed_q32 = step_q32;
            cam_turn_bins_plan_isr(g, &record, &motion);
        }
        cam_machine_ilc_poll(&rig.machine, cam_state_rehearsing,
                             !cam_machine_status(&rig.machine).is_u_at_rest);
        rig.machine.ilc.blending = 0;
    }
    TEST_ASSERT_TRUE(rig.machine.ilc.n_turns > 0u);
    return rig.machine.ilc.floor_q6;
}

/// 78 / 64 quanta by the root of the ticks, and a nanometre.
static void test_a_coarse_scale_tells_less(void)
{
    TEST_ASSERT_UINT32_WITHIN(2, 64 + 78 * 10 / 31, floor_of(10));
    TEST_ASSERT_UINT32_WITHIN(10, 64 + 78 * 1000 / 31, floor_of(1000));
}
