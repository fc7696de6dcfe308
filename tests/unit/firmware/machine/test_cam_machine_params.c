// SPDX-License-Identifier: Apache-2.0
// Changes of all parameters at once, the ones that are kept, and the numbers of a refusal.
#include "fixture_can.h"
#include "hal_host.h"
#include "unity.h"
#include <string.h> // strstr

static fixture_can_t f;
static cam_machine_t *const m = &f.rig.machine;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_can_init(&f, &part, 20000);
    fixture_can_start(&f);
}

static void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&f.rig, id, value));
}

static void stage(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage(m, id, value));
}

static void test_commit_brings_all_into_force_in_one_tick(void)
{
    fixture_rig_ticks(&f.rig, 2);
    const uint32_t config = fixture_rig_status(&f.rig).config;
    const uint32_t version = m->version;
    cam_machine_stage_begin(m);
    stage(cam_param_k1_ns, 300);
    stage(cam_param_lead_ns, 70000);
    stage(cam_param_counts_per_turn, 20000);
    TEST_ASSERT_EQUAL_INT32(10000, m->params.counts_per_turn);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage_commit(m));
    fixture_rig_tick(&f.rig);
    TEST_ASSERT_EQUAL_UINT32(config + 1u, fixture_rig_status(&f.rig).config);
    TEST_ASSERT_EQUAL_INT32(300, m->params.k1_ns);
    TEST_ASSERT_EQUAL_INT32(20000, m->params.counts_per_turn);
    TEST_ASSERT_EQUAL_UINT32(version + 1u, m->version);
    TEST_ASSERT_EQUAL_INT(cam_err_params_begin, cam_machine_stage_commit(m)); // once
}

/// A commit is refused as a whole, also after a change by another.
static void test_commit_that_is_refused_leaves_all_as_they_were(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    const cam_params_t before = m->params;
    cam_machine_stage_begin(m);
    stage(cam_param_x_trim_nm, 1000);
    stage(cam_param_encoder_sign, -1);
    TEST_ASSERT_EQUAL_INT(cam_err_param_range, cam_machine_stage(m, cam_param_lead_ns, -1));
    TEST_ASSERT_EQUAL_INT(cam_err_param_state, cam_machine_stage_commit(m));
    TEST_ASSERT_EQUAL_INT(cam_param_encoder_sign, m->refusal.param);
    TEST_ASSERT_EQUAL_INT64(0, m->refusal.needed | m->refusal.limit);
    stage(cam_param_encoder_sign, 1);
    stage(cam_param_spindle_limit_mrpm, 1000000);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, cam_machine_stage_commit(m));
    TEST_ASSERT_EQUAL_MEMORY(&before, &m->params, sizeof before);
    setUp();
    TEST_ASSERT_EQUAL_INT(cam_err_params_begin, cam_machine_stage(m, cam_param_k1_ns, 5));
    cam_machine_stage_begin(m);
    stage(cam_param_k1_ns, 5);
    set(cam_param_lead_ns, 60000);
    TEST_ASSERT_EQUAL_INT(cam_err_params_stale, cam_machine_stage_commit(m));
    TEST_ASSERT_EQUAL_INT32(0, m->params.k1_ns);
}

/// Without a step of U's command.
static void test_feed_forward_changes_in_ready_while_u_rests(void)
{
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    TEST_ASSERT_LESS_THAN_UINT32(40000, fixture_rig_until(&f.rig, cam_state_ready, 40000));
    TEST_ASSERT_FALSE(fixture_rig_status(&f.rig).is_u_at_rest);
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_set_param(m, cam_param_k1_ns, 400000));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_set_param(m, cam_param_x_trim_nm, 1));
    fixture_rig_ticks(&f.rig, 4000);
    const int32_t before_nm = f.rig.last.out[hal_axis_u].pos_nm;
    set(cam_param_k1_ns, 400000);
    set(cam_param_k2_us2, 9000);
    for (uint32_t i = 0; i < 100u; i++) {
        fixture_rig_tick(&f.rig);
        TEST_ASSERT_EQUAL_INT32(before_nm, f.rig.last.out[hal_axis_u].pos_nm);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_ready, fixture_rig_state());
}

static void expect_kept(cam_kept_t kept)
{
    TEST_ASSERT_EQUAL_INT(kept, cam_machine_params_kept(m));
}

static void test_saved_parameters_are_there_after_a_restart(void)
{
    expect_kept(cam_kept_none);
    TEST_ASSERT_EQUAL_INT(cam_err_params_none, cam_machine_revert_params(m));
    set(cam_param_lead_ns, 61000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_save_params(m));
    expect_kept(cam_kept_same);
    const uint32_t version = m->version, checksum = m->checksum;
    set(cam_param_k2_us2, 44);
    expect_kept(cam_kept_changed);
    TEST_ASSERT_EQUAL_UINT32(version + 1u, m->version);
    fixture_can_start(&f);
    TEST_ASSERT_EQUAL_INT32(61000, m->params.lead_ns);
    TEST_ASSERT_EQUAL_INT32(0, m->params.k2_us2);
    TEST_ASSERT_EQUAL_UINT32(version, m->version);
    TEST_ASSERT_EQUAL_UINT32(checksum, m->checksum);
    TEST_ASSERT_EQUAL_STRING("params: version 1 in use", fixture_can_line(1));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_restore_defaults(m));
    TEST_ASSERT_EQUAL_INT32(100000, m->params.lead_ns);
    expect_kept(cam_kept_changed);
    fixture_rig_ticks(&f.rig, 2);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_revert_params(m));
    TEST_ASSERT_EQUAL_INT32(61000, m->params.lead_ns);
    expect_kept(cam_kept_same);
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_save_params(m));
}

/// As of a port with hal_params_keep() but without hal_params_kept(), or with a bad flash.
static void test_save_is_refused_when_the_port_does_not_return_the_text(void)
{
    hal_host.slow.n_store = 0;
    TEST_ASSERT_EQUAL_INT(cam_err_params_keep, cam_machine_save_params(m));
    hal_host.slow.n_store = UINT32_MAX;
    hal_host.slow.forgets_params = true;
    TEST_ASSERT_EQUAL_INT(cam_err_params_keep, cam_machine_save_params(m));
    expect_kept(cam_kept_none);
    hal_host.slow.forgets_params = false;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_save_params(m));
    hal_host.slow.n_store = 0; // the text is there already, but the port says that it failed
    TEST_ASSERT_EQUAL_INT(cam_err_params_keep, cam_machine_save_params(m));
    hal_host.slow.n_store = UINT32_MAX;
    hal_host.slow.forgets_params = true;
    // Most of the texts are as long as the kept one: that depends on the digits of the CRC.
    for (int32_t lead_ns = 101000; lead_ns <= 108000; lead_ns += 1000) {
        set(cam_param_lead_ns, lead_ns);
        TEST_ASSERT_EQUAL_INT(cam_err_params_keep, cam_machine_save_params(m));
        expect_kept(cam_kept_changed);
    }
}

/// A text that this image or another has kept.
static void keep(const cam_params_t *params, bool is_damaged)
{
    static char text[cam_param_store_most_bytes];
    const uint32_t n = cam_param_store_write(text, params, 8);
    hal_host.slow.params = (hal_params_t){.bytes = text, .size = n, .is_damaged = is_damaged};
    fixture_can_start(&f);
}

/// A part is never begun at an override that nobody set since the start; the trim is of the
/// machine.
static void test_overrides_are_whole_after_a_restart_and_a_revert(void)
{
    set(cam_param_feed_override_ppm, 800000);
    set(cam_param_spindle_override_ppm, 1100000);
    set(cam_param_x_trim_nm, 2000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_save_params(m));
    expect_kept(cam_kept_changed);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_revert_params(m));
    TEST_ASSERT_EQUAL_INT32(1000000, m->params.feed_override_ppm);
    expect_kept(cam_kept_same);
    cam_params_t params = m->params; // as an older image or a hand has written it
    params.feed_override_ppm = 700000;
    params.spindle_override_ppm = 900000;
    keep(&params, false);
    TEST_ASSERT_EQUAL_INT32(1000000, m->params.feed_override_ppm);
    TEST_ASSERT_EQUAL_INT32(1000000, m->params.spindle_override_ppm);
    TEST_ASSERT_EQUAL_INT32(2000, m->params.x_trim_nm);
    expect_kept(cam_kept_same);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_revert_params(m));
    TEST_ASSERT_EQUAL_INT32(1000000, m->params.feed_override_ppm);
    TEST_ASSERT_EQUAL_INT32(1000000, m->params.spindle_override_ppm);
}

/// Damaged, or beyond what this tick rate allows: the defaults are used, and a line says so. Of two
/// texts the whole one is used. test_cam_log_text.c has the lines about another image.
static void test_kept_parameters_that_cannot_be_used_have_a_line(void)
{
    static const char rubbish[] = "lead_ns = 5\n";
    cam_params_t params = cam_param_defaults();
    keep(&params, true);
    TEST_ASSERT_EQUAL_STRING("params: version 8 in use, what was to be saved after it is not whole",
                             fixture_can_line(1));
    hal_host.slow.params = (hal_params_t){.bytes = rubbish, .size = sizeof rubbish - 1u};
    fixture_can_start(&f);
    expect_kept(cam_kept_damaged);
    TEST_ASSERT_EQUAL_STRING("params: the kept parameters are damaged - defaults in use",
                             fixture_can_line(1));
    TEST_ASSERT_EQUAL_INT(cam_err_params_damaged, cam_machine_revert_params(m));
    params.lead_ns = 20000000;
    keep(&params, false);
    expect_kept(cam_kept_damaged);
    TEST_ASSERT_NOT_NULL(strstr(fixture_can_line(1), "do not fit the tick rate - defaults in use"));
    TEST_ASSERT_EQUAL_INT32(100000, m->params.lead_ns);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_save_params(m));
    expect_kept(cam_kept_same);
}

/// A value is refused with demand and limit of a parameter.
static void expect_refused(cam_err_t err, cam_param_id_t id, int32_t value, cam_param_id_t of)
{
    TEST_ASSERT_EQUAL_INT(err, cam_machine_set_param(m, id, value));
    TEST_ASSERT_EQUAL_INT(err, m->refusal.err);
    TEST_ASSERT_EQUAL_INT(of, m->refusal.param);
}

/// A jerk whose window would be too long is refused with the least that is not.
static void test_refusal_has_demand_and_limit(void)
{
    const cam_refusal_t *last = &m->refusal;
    expect_refused(cam_err_jerk, cam_param_u_jerk_m_per_s3, 1, cam_param_u_jerk_m_per_s3);
    TEST_ASSERT_EQUAL_INT64(1, last->needed);
    TEST_ASSERT_GREATER_THAN_INT64(1, last->limit);
    set(cam_param_u_jerk_m_per_s3, (int32_t)last->limit);
    expect_refused(cam_err_param_tick, cam_param_lead_ns, 20000000, cam_param_lead_ns);
    TEST_ASSERT_EQUAL_INT64(20000000, last->needed);
    TEST_ASSERT_LESS_THAN_INT64(20000000, last->limit);
    set(cam_param_lead_ns, (int32_t)last->limit);
    TEST_ASSERT_EQUAL_INT(cam_err_param_tick, // only their sum is too long
                          cam_machine_set_param(m, cam_param_u_scale_latency_ns, 9));
    TEST_ASSERT_EQUAL_INT64(last->limit + 9, last->needed);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_restore_defaults(m));
    TEST_ASSERT_TRUE(fixture_rig_bring(&f.rig, cam_state_ready));
    expect_refused(cam_err_u_acceleration, cam_param_u_acceleration_mm_per_s2, 900, cam_n_params);
    TEST_ASSERT_EQUAL_INT64(900, last->limit);
    TEST_ASSERT_GREATER_THAN_INT64(900, last->needed);
    TEST_ASSERT_GREATER_THAN_UINT32(0, last->highest_mrpm);
    TEST_ASSERT_EQUAL_INT64(900, cam_machine_refusal(m, cam_err_u_acceleration).limit);
    const cam_refusal_t other =
        cam_machine_refusal(m, cam_err_u_speed); // of which no number is kept
    TEST_ASSERT_EQUAL_INT(cam_err_u_speed, other.err);
    TEST_ASSERT_EQUAL_INT(cam_n_params, other.param);
    TEST_ASSERT_EQUAL_INT64(0, other.needed);
    TEST_ASSERT_EQUAL_INT64(0, other.limit);
}

/// A port with steps begins with what they pass on, and a higher speed is refused with that number.
static void test_speed_beyond_an_output_is_refused_with_the_highest(void)
{
    hal_host.slow.scale[hal_axis_x].most_um_per_s = 36000;
    cam_machine_init(m, &g_cam, 20000, hal_host_clock_hz);
    TEST_ASSERT_EQUAL_INT32(36000, m->params.x_speed_um_per_s);
    TEST_ASSERT_EQUAL_INT32(200000, m->params.z_speed_um_per_s);
    expect_refused(cam_err_param_output, cam_param_x_speed_um_per_s, 36001,
                   cam_param_x_speed_um_per_s);
    TEST_ASSERT_EQUAL_INT64(36001, m->refusal.needed);
    TEST_ASSERT_EQUAL_INT64(36000, m->refusal.limit);
}
