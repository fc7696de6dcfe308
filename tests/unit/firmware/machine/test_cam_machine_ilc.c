// SPDX-License-Identifier: Apache-2.0
// Learning as the slow side of the machine sees it: which values it takes back, when it works, what
// is handed over, and the parameters shown by turns that the test makes: gains, probe, ripple.
#include "cam_learning_inner.h" // cam_harmonic_correction_sum_q6
#include "cam_machine_inner.h"  // cam_machine_ilc_poll
#include "rig_bench.h"
#include <math.h> // cos, lround, sin

#define TURN 6.283185307179586

enum { tick_us = 50, one_q16 = 65536, spare_ticks = 4, spare_ticks2 = 16 };

static cam_machine_t *const m = &rig.machine;

static cam_err_t set_learned(uint32_t index, int32_t value)
{
    return cam_machine_set_learned(m, index, value);
}

static int32_t learned(uint32_t index)
{
    return cam_ilc_get(&m->ilc, index);
}

/// What was learned of one machine is set where nothing cuts; elsewhere it is refused unchanged.
static void test_learned_values_are_set_in_off_and_ready_only(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, 1234));
    bring(cam_state_ready);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, 5678));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    until(cam_state_cutting);
    TEST_ASSERT_EQUAL_INT(cam_err_param_state, set_learned(cam_ilc_value_phase, 9));
    TEST_ASSERT_EQUAL_INT32(5678, learned(cam_ilc_value_phase));
    TEST_ASSERT_EQUAL_INT(cam_err_param_id, set_learned(cam_ilc_n_values, 0));
}

/// A drive's constant goes as far as learning itself could lead it, in both senses; the limit of
/// one does not hold for another value.
static void test_constants_of_the_drive_stay_within_what_can_be_learned(void)
{
    const cam_params_t *p = &m->params;
    const int64_t k1_ns = (int64_t)p->k1_ns + p->lead_ns + spare_ticks * tick_us * 1000;
    const int64_t k2_us2 = (int64_t)p->k2_us2 + spare_ticks2 * tick_us * tick_us;
    const uint32_t index[] = {cam_ilc_value_k1, cam_ilc_value_k2};
    const int32_t most[] = {(int32_t)(k1_ns * one_q16 / (tick_us * 1000)),
                            (int32_t)(k2_us2 * one_q16 / (tick_us * tick_us))};
    for (int i = 0; i < 2; i++) {
        for (int32_t sign = -1; sign <= 1; sign += 2) {
            TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(index[i], sign * (most[i] - 2)));
            TEST_ASSERT_EQUAL_INT(cam_err_param_range, set_learned(index[i], sign * (most[i] + 2)));
            TEST_ASSERT_EQUAL_INT32(sign * (most[i] - 2), learned(index[i]));
        }
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_phase, INT32_MAX));
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, set_learned(cam_ilc_value_gain, INT16_MAX + 1));
}

/// A constant of the drive or a delay that is set anew ends what was learned on top of it. What the
/// encoder's error depends on makes the ripple walk. Another parameter does neither.
static void test_new_constants_of_the_drive_forget_what_was_learned(void)
{
    static const cam_param_id_t ids[] = {cam_param_feed_nm,
                                         cam_param_eccentricity_nturn,
                                         cam_param_eccentricity_udeg,
                                         cam_param_ripple_turns,
                                         cam_param_k1_ns,
                                         cam_param_k2_us2,
                                         cam_param_lead_ns,
                                         cam_param_u_scale_latency_ns};
    for (uint32_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        const bool is_of_drive = i >= 4u;
        TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 1000));
        m->ilc.blending = 0;
        cam_machine_unlearn(m, ids[i]);
        TEST_ASSERT_EQUAL_INT32(is_of_drive ? 0 : 1000, learned(cam_ilc_value_k1));
        if (!is_of_drive) {
            TEST_ASSERT_EQUAL_HEX8(i > 0u ? cam_ilc_blend_ripple : 0, m->ilc.blending);
        }
    }
}

static void poll(cam_state_t state)
{
    cam_machine_ilc_poll(m, state, !cam_machine_status(m).is_u_at_rest);
}

/// Poll in ready. @return configurations that were handed over
static uint32_t generations(uint32_t n_polls)
{
    const uint32_t before = m->generation;
    for (uint32_t i = 0; i < n_polls; i++) {
        poll(cam_state_ready);
        fixture_rig_ticks(&rig, 2);
    }
    return m->generation - before;
}

/// In ready with these parameters, and nothing left to hand over.
static void settle(int32_t harmonics, int32_t turns)
{
    set(cam_param_learn_harmonics, harmonics);
    set(cam_param_ripple_turns, turns);
    bring(cam_state_ready);
    (void)generations(400);
    TEST_ASSERT_EQUAL_UINT32(0, generations(10));
}

static const cam_learned_t *offered(void)
{
    return &atomic_load(&m->core->config.offered)->learned;
}

/// Without learning there is nothing to hand over. A value that is set is walked to, one new
/// configuration for each step that changes something, and none when it is reached, nor while the
/// interrupt has not taken the last one.
static void test_only_what_changes_is_handed_over(void)
{
    settle(0, 0);
    TEST_ASSERT_EQUAL_HEX8(0, m->ilc.blending);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 640));
    expect_set(cam_ok, cam_param_feed_ramp_turns, 2);
    const uint32_t before = m->generation;
    for (int i = 0; i < 100; i++) {
        poll(cam_state_ready);
    }
    TEST_ASSERT_EQUAL_UINT32(before, m->generation);
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
    TEST_ASSERT_EQUAL_INT32(640, offered()->k1_q16);
    TEST_ASSERT_EQUAL_UINT32(0, generations(100));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k1, 0));
    const uint32_t last = m->generation;
    cam_machine_poll(m);
    TEST_ASSERT_GREATER_THAN_UINT32(last, m->generation);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_k2, -320));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
    TEST_ASSERT_EQUAL_INT32(-320, offered()->k2_q16);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_friction, 64));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(2000));
    TEST_ASSERT_EQUAL_INT32(64, offered()->friction_q6);
}

/// A correction of U and a ripple of the spindle alone are handed over, too, without the constants;
/// so is what the encoder measures and U does not follow.
static void test_a_correction_and_a_ripple_are_handed_over(void)
{
    settle(8, 64);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_speed, 1 << 20));
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_correction, 64 * 64));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(4000));
    TEST_ASSERT_NOT_EQUAL_INT16(0, offered()->c[0]);
    TEST_ASSERT_EQUAL_INT16(0, offered()->dm[1]);
    TEST_ASSERT_EQUAL_INT(cam_ok, set_learned(cam_ilc_value_ripple + 2, 300));
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(4000));
    TEST_ASSERT_NOT_EQUAL_INT16(0, offered()->dm[1]);
    setUp();
    settle(m->params.learn_harmonics, 4);
    cam_config_t *copy = cam_config_copy(&m->core->config);
    copy->learned.dm[1]++; // as an eccentricity would
    cam_machine_offer_copy(m);
    fixture_rig_ticks(&rig, 2);
    m->ilc.blending = cam_ilc_blend_ripple;
    TEST_ASSERT_GREATER_THAN_UINT32(0, generations(400));
    TEST_ASSERT_EQUAL_INT16(0, offered()->dm[1]);
}

/// A sin(angle - phase) of the encoder, whose phase is measured in the sense of its counts.
static void test_eccentricity_is_taken_off_in_the_sense_of_cutting(void)
{
    for (int32_t sense = -1; sense <= 1; sense += 2) {
        part.direction = sense;
        fixture_rig_init(&rig, &part, 20000);
        set(cam_param_eccentricity_nturn, 100000);
        set(cam_param_eccentricity_udeg, 30000000);
        settle(0, 0);
        for (int i = 0; i <= cam_learned_points; i += 32) {
            const double angle = TURN * (i / 256.0 - sense / 12.0);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 838.86 * sin(angle), offered()->dm[i]);
            TEST_ASSERT_EQUAL_INT16(0, offered()->d[i]);
        }
    }
}

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
        m->ilc.blending = cases[i].blending;
        m->ilc.state = cam_state_off;
        poll(cam_state_ready);
        TEST_ASSERT_EQUAL_UINT8(cases[i].works ? cam_state_ready : cam_state_off, m->ilc.state);
        fixture_rig_ticks(&rig, 2);
    }
}

/// The first reason that holds, in this order.
static void test_why_nothing_is_learned_is_known(void)
{
    m->params.learn_harmonics = 0;
    TEST_ASSERT_EQUAL_INT(cam_ilc_not_asked, cam_machine_learning(m).reason);
    m->params.learn_harmonics = 8;
    TEST_ASSERT_EQUAL_INT(cam_ilc_not_measured, cam_machine_learning(m).reason);
    hal_host.slow.measures_u = true;
    TEST_ASSERT_EQUAL_INT(cam_ilc_all, cam_machine_learning(m).reason);
    hal_host.slow.force.quantum_un = 20000;
    set(cam_param_servo_integral_mHz, 0);
    set(cam_param_servo_crossover_hz, 166); // four times 41.7 turns per second are 166.7
    TEST_ASSERT_EQUAL_INT(cam_ilc_slow_loop, cam_machine_learning(m).reason);
    set(cam_param_servo_crossover_hz, 167);
    TEST_ASSERT_EQUAL_INT(cam_ilc_all, cam_machine_learning(m).reason);
    m->table.n_lobes = 2;
    TEST_ASSERT_EQUAL_INT(cam_ilc_lobes, cam_machine_learning(m).reason);
    m->table.speed = m->table.u;
    TEST_ASSERT_EQUAL_INT(cam_ilc_modulated, cam_machine_learning(m).reason);
    m->has_table = false;
    TEST_ASSERT_EQUAL_INT(cam_ilc_no_table, cam_machine_learning(m).reason);
}

// Turns that the test makes

enum { n_ticks = 400, set_nm = 100000, error_nm = 1000 };

static uint32_t turn;      ///< number of the last one
static double ripple_turn; ///< of the encoder, three waves a turn

/// Start anew with a drive of which nothing is known.
static void begin(void)
{
    setUp();
    turn = 0;
    ripple_turn = 0.0;
    hal_host.slow.measures_u = true;
    set(cam_param_k1_ns, 0);
    set(cam_param_k2_us2, 0);
    set(cam_param_learn_harmonics, 4);
}

/// Close a turn in which U moves by a cosine and lags by a sine, and let the slow side treat
/// it.
static void play(cam_state_t state)
{
    cam_turn_bins_t *g = &m->core->bins;
    turn++;
    const uint32_t bank = turn & 1u;
    for (uint32_t i = 0; i < n_ticks; i++) {
        const double at = (i + 0.5) / n_ticks;
        const uint32_t b = i * cam_turn_bins_n / n_ticks;
        cam_turn_bin_t *bin = &g->bin[bank * cam_turn_bins_n + b];
        bin->n++;
        bin->u_nm += (int32_t)lround(set_nm * cos(TURN * at));
        bin->error_q6 -= (int32_t)lround(64.0 * error_nm * sin(TURN * at));
        const double angle = at + ripple_turn * sin(3.0 * TURN * at);
        bin->angle_q24 += (int32_t)lround((angle - (double)b / cam_turn_bins_n) * 16777216.0);
    }
    g->closed[bank] = (cam_turn_t){.turn = turn,
                                   .is_steady = true,
                                   .is_level = true,
                                   .state = state,
                                   .speed_q32 = 10737418,
                                   .scale_q30 = 1 << 30};
    g->closed_turn[bank] = turn | 1u << 24;
    g->at_q8 = (turn + 1u) << 8 | 10u;
    m->ilc.blending = 0;
    m->ilc.good_from = 0;
    for (int i = 0; i < 40; i++) {
        poll(state);
    }
}

static void play_turns(int n, cam_state_t state)
{
    while (n-- > 0) {
        play(state);
    }
}

/// An error of a hundredth, late by a quarter turn, is k1 w = 1 / 100: of that a step of the
/// rehearsal takes the share that is set, and in the cut its own; of none nothing is learned there.
static void test_gains_are_those_that_are_set(void)
{
    static const struct {
        cam_param_id_t id;
        cam_state_t state;
        int32_t gains_ppm[3];
    } cases[] = {{cam_param_learn_gain_ppm, cam_state_rehearsing, {150000, 400000, 600000}},
                 {cam_param_learn_cut_gain_ppm, cam_state_cutting, {0, 100000, 200000}}};
    for (int i = 0; i < 6; i++) {
        const bool is_cut = i >= 3;
        const int32_t gain_ppm = cases[i / 3].gains_ppm[i % 3];
        begin();
        set(cases[i / 3].id, gain_ppm);
        play_turns(is_cut ? 2 : 1, cases[i / 3].state);
        m->ilc.n_steps = is_cut ? 20 : m->ilc.n_steps; // the larger gain of the first turns is over
        const int32_t before_q16 = m->ilc.drive.k1_q16;
        play(cases[i / 3].state);
        const double due = gain_ppm * 1e-6 * 0.01 * n_ticks / TURN;
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * due + (is_cut ? 1e-4 : 0.0), due,
                                  (m->ilc.drive.k1_q16 - (is_cut ? before_q16 : 0)) / 65536.0);
    }
}

/// What is learned takes no more from the friction than is configured.
static void test_learned_friction_leaves_none_at_least(void)
{
    begin();
    set(cam_param_u_friction_nm, 1000);
    play(cam_state_rehearsing);
    m->ilc.drive.friction_q6 = -64 * 5000;
    play(cam_state_rehearsing);
    TEST_ASSERT_EQUAL_INT32(-64 * 1000, m->ilc.drive.friction_q6);
}

/// The first probe is half of the one that is set, at least three steps of the scale, at each of 4
/// harmonics and the mean.
static void test_probe_is_the_one_that_is_set_or_three_steps_of_the_scale(void)
{
    static const int32_t cases[][3] = {{2000, 0, 2000}, {2000, 600, 2000}, {2000, 700, 2100}};
    for (int i = 0; i < 3; i++) {
        begin();
        set(cam_param_probe_nm, cases[i][0]);
        set(cam_param_u_scale_nm, cases[i][1]);
        play_turns(8, cam_state_rehearsing);
        TEST_ASSERT_EQUAL_UINT8(cam_ilc_probing, m->ilc.phase);
        TEST_ASSERT_UINT32_WITHIN(8, 5u * 32u * (uint32_t)cases[i][2],
                                  cam_harmonic_correction_sum_q6(&m->ilc.correction));
        // 78 / 64 of a scale's step and of 63 nm, which a count of the encoder is, over 20
        TEST_ASSERT_UINT32_WITHIN(8, 64u + 78u * ((uint32_t)cases[i][1] + 63u) / 20u,
                                  m->ilc.floor_q6);
    }
}

/// A mean of the ripple has the turns that are set, but two at least; of a table that modulates the
/// speed, or without one, there is none.
static void test_turns_of_the_ripple_are_those_that_are_set(void)
{
    static const struct {
        int32_t turns;
        bool is_modulated, has_no_table;
        uint32_t n_mean;
    } cases[] = {{0, false, false, 0}, {1, false, false, 2}, {2, false, false, 2},
                 {3, false, false, 3}, {2, true, false, 0},  {2, false, true, 0}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin();
        set(cam_param_ripple_turns, cases[i].turns);
        m->table.speed = cases[i].is_modulated ? m->table.u : m->table.speed;
        m->has_table = !cases[i].has_no_table;
        play_turns(6, cam_state_ready);
        TEST_ASSERT_EQUAL_UINT32(cases[i].n_mean, m->ilc.ripple.n_mean);
    }
}

/// Counts imitate a ripple of up to a quarter of a count, unless their edges are timed.
static void test_a_ripple_that_counts_may_imitate_is_not_learned(void)
{
    for (int i = 0; i < 3; i++) {
        begin();
        set(cam_param_ripple_turns, 2);
        hal_host.slow.has_edge_time = i == 2;
        ripple_turn = (i == 1 ? 0.27 : 0.23) / m->params.counts_per_turn;
        play_turns(6, cam_state_ready);
        TEST_ASSERT_EQUAL_UINT32(2, m->ilc.ripple.n_mean);
        TEST_ASSERT_EQUAL(i > 0, cam_ripple_sum(&m->ilc.ripple) > 0u);
    }
}

/// The depth of cut counts from the largest radius of the part and from U's outermost position.
static void test_mean_force_of_the_chip_has_the_whole_depth(void)
{
    cam_table_t *table = &m->table;
    const struct {
        uint32_t *of;
        int32_t by_nm, deeper_nm;
    } cases[] = {{&table->depth_nm, 64000, 64000},
                 {(uint32_t *)&table->u_min_nm, -64000, 64000},
                 {(uint32_t *)&table->x_max_nm, 64000, 64000},
                 {(uint32_t *)&table->x.value_offset, 64000, -64000}};
    int32_t before_q6 = 0;
    for (uint32_t i = 0; i < 5u; i++) {
        begin();
        play_turns(2, cam_state_cutting);
        table->depth_nm = 1000000;
        *cases[i > 0u ? i - 1u : 0u].of += i > 0u ? (uint32_t)cases[i - 1u].by_nm : 0u;
        m->ilc.drive.chip_q32 = m->ilc.chip_mean_q32 = 1 << 26; // a 64th
        for (int k = 0; k < 400; k++) {
            m->core->bins.z_vel_q10 = (int32_t)(250000.0 * 1024.0 * 10737418.0 / 4294967296.0);
            m->ilc.blending = cam_ilc_blend_drive;
            poll(cam_state_cutting);
            fixture_rig_ticks(&rig, 2);
        }
        const int32_t q6 = offered()->chip_q6;
        TEST_ASSERT_NOT_EQUAL_INT32(0, q6);
        before_q6 = i == 0u ? q6 : before_q6;
        TEST_ASSERT_INT32_WITHIN(8, i > 0u ? cases[i - 1u].deeper_nm : 0, q6 - before_q6);
    }
}

/// Lobes are ground: their depth is not known, and nothing is learned of a chip.
static void test_lobes_have_no_chip(void)
{
    begin();
    play_turns(2, cam_state_cutting);
    m->table.n_lobes = 2;
    m->table.depth_nm = 1000000;
    m->ilc.drive.chip_q32 = m->ilc.chip_mean_q32 = 1 << 30;
    for (int k = 0; k < 400; k++) {
        m->core->bins.z_vel_q10 = (int32_t)(250000.0 * 1024.0 * 10737418.0 / 4294967296.0);
        m->ilc.blending = cam_ilc_blend_drive;
        poll(cam_state_cutting);
        fixture_rig_ticks(&rig, 2);
    }
    TEST_ASSERT_EQUAL_INT32(0, offered()->chip_q6);
}

/// While U plays the table, learned constants and corrections shrink until its command is within
/// the stroke; out of the work they stay.
static void test_what_is_learned_fits_into_the_stroke(void)
{
    static const struct {
        cam_state_t state;
        int32_t stroke_nm, k1_ticks; ///< 400 times a power of 7 / 8
    } cases[] = {{cam_state_rehearsing, 1200000, 205},
                 {cam_state_cutting, 1200000, 205},
                 {cam_state_cutting, 1000, 0},
                 {cam_state_ready, 1200000, 400}};
    for (int i = 0; i < 4; i++) {
        begin();
        play_turns(2, cases[i].state);
        m->params.u_stroke_nm = cases[i].stroke_nm;
        m->ilc.drive = (cam_drive_t){.k1_q16 = 400 * one_q16};
        m->ilc.correction.c_q6[0].re = 64 * 30000;
        m->ilc.blending = cam_ilc_blend_drive;
        fixture_rig_ticks(&rig, 2);
        poll(cases[i].state);
        TEST_ASSERT_EQUAL_INT32(cases[i].k1_ticks, m->ilc.drive.k1_q16 / one_q16);
        TEST_ASSERT_EQUAL(i < 3, m->ilc.is_limited);
    }
}

/// The steps of a new ripple grow with the speed of the turn, whatever the limit of the speed is.
static void test_steps_of_the_ripple_are_those_of_the_speed(void)
{
    static const uint32_t limits_mrpm[] = {3000000, 10000};
    for (int i = 0; i < 2; i++) {
        begin();
        set(cam_param_ripple_turns, 2);
        set(cam_param_amplitude_ppm, i * 1000000); // without a shape U follows any step
        play_turns(2, cam_state_ready);            // at 3000 r/min
        m->limit_mrpm = limits_mrpm[i];
        m->ilc.ripple.mean[2].re = 4000;
        m->ilc.blending = cam_ilc_blend_ripple;
        int n_polls = 0;
        for (; n_polls < 1000 && m->ilc.blending != 0u; n_polls++) {
            poll(cam_state_ready);
            fixture_rig_ticks(&rig, 2);
            m->ilc.blend_from_q8 = m->core->bins.at_q8; // it need not wait
        }
        TEST_ASSERT_INT_WITHIN(1, 9, n_polls); // 3000000 * 32 / 200000 a step
    }
}
