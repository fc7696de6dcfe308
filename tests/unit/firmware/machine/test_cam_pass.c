// SPDX-License-Identifier: Apache-2.0
// Several passes of one table: their records, their order, their numbers, what refuses them.
#include "cam_machine_inner.h" // cam_pass_count, cam_pass_params, cam_pass_highest_mrpm
#include "fixture_newer.h"
#include "rig_bench.h"

static cam_machine_t *const m = &rig.machine;
static fixture_image_t image;
static cam_table_t table;

static double x_nm, turns; ///< X when the last cut began, and how long it was

static const fixture_pass_t three[3] = {
    {150000, 200000, 1200000, 0},
    {20000, 150000, 1500000, 0},
    {0, 100000, 2000000, 0},
};

/// Check a table with n passes.
static cam_err_t check(const fixture_pass_t *passes, uint32_t n)
{
    fixture_image_make(&image, &part);
    fixture_newer_passes(&image, passes, n);
    return cam_table_check(image.bytes, image.size, &table);
}

/// Stock falls from pass to pass to 0; feeds and speeds are those of the parameters.
static void test_records_out_of_range_are_refused(void)
{
    static const struct {
        fixture_pass_t pass[2];
        cam_err_t err;
    } cases[] = {
        {{{100, 100, 1000, 0}, {1, 100, 1000, 0}}, cam_err_image_channel},
        {{{0, 100, 1000, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{-1, 100, 1000, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{10000001, 100, 1000, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{100, 0, 1000, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{100, 10000001, 1000, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{100, 100, 0, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{100, 100, 60000001, 0}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{100, 100, 1000, 1}, {0, 100, 1000, 0}}, cam_err_image_channel},
        {{{10000000, 10000000, 60000000, 0}, {0, 1, 1, 0}}, cam_ok},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_INT(cases[i].err, check(cases[i].pass, 2));
    }
}

static void test_highest_speed_is_that_of_the_pass_that_allows_the_least(void)
{
    cam_params_t params = cam_param_defaults();
    params.z_speed_um_per_s = 10000;
    for (uint32_t i = 0; i < 3u; i++) {
        fixture_pass_t passes[3] = {three[0], three[1], three[2]};
        for (uint32_t k = 0; k < 3u; k++) {
            passes[k].feed_nm = k + i == 2u ? 400000 : 100000;
        }
        TEST_ASSERT_EQUAL_INT(cam_ok, check(passes, 3));
        TEST_ASSERT_UINT32_WITHIN(2000, 1500000, cam_pass_highest_mrpm(&table, &params, 20000));
    }
}

static void select_passes(const fixture_pass_t *passes)
{
    fixture_rig_init(&rig, &part, 20000);
    fixture_newer_passes(&rig.image, passes, 3);
    expect_select(cam_ok);
    fixture_rig_ticks(&rig, 3);
}

static void bring_ready(void)
{
    select_passes(three);
    bring(cam_state_ready);
}

/// Start, and cut to the end.
static void cut(void)
{
    cam_err_t err = cam_machine_start(m);
    for (int i = 0; i < 200 && err == cam_err_busy; i++) { // the spindle slows down
        fixture_rig_ticks(&rig, 500);
        cam_machine_poll(m);
        err = cam_machine_start(m);
    }
    TEST_ASSERT_EQUAL_INT(cam_ok, err);
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_cutting, 400000));
    const int64_t from_q32 = fixture_rig_status(&rig).pos_q32;
    x_nm = rig.last.out[hal_axis_x].pos_nm;
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_disengaging, 400000));
    turns = (double)(fixture_rig_status(&rig).pos_q32 - from_q32) / 4294967296.0;
    TEST_ASSERT_LESS_THAN_UINT32(400000, fixture_rig_until(&rig, cam_state_ready, 400000));
    fixture_rig_ticks(&rig, 3);
    cam_machine_poll(m);
    fixture_rig_ticks(&rig, 3);
}

/// Each start cuts the next pass with its feed, speed and stock; after the last comes the first.
static void test_starts_cut_one_pass_after_the_other(void)
{
    bring_ready();
    double x0_nm = 0.0;
    for (uint32_t i = 0; i < 5; i++) {
        const fixture_pass_t *pass = &three[i % 3u];
        TEST_ASSERT_EQUAL_UINT32(i % 3u, m->pass);
        fixture_rig_ticks(&rig, 2000);
        TEST_ASSERT_EQUAL_INT32((int32_t)pass->spindle_mrpm, hal_host.out.spindle_mrpm);
        cut();
        x0_nm = i == 0u ? x_nm - pass->allowance_nm : x0_nm;
        TEST_ASSERT_DOUBLE_WITHIN(20.0, x0_nm + pass->allowance_nm, x_nm);
        TEST_ASSERT_DOUBLE_WITHIN(0.1, 1e6 / pass->feed_nm + 2.0, turns); // 1 mm and the ramps
    }
}

static void test_pass_that_is_stopped_or_fails_is_cut_again(void)
{
    bring_ready();
    cut();
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    (void)fixture_rig_until(&rig, cam_state_cutting, 400000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stop(m));
    (void)fixture_rig_until(&rig, cam_state_ready, 400000);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
    (void)fixture_rig_until(&rig, cam_state_cutting, 400000);
    hal_host_fault_estop(true);
    (void)fixture_rig_until(&rig, cam_state_fault, 100);
    hal_host_fault_estop(false);
    cam_machine_poll(m);
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
}

static void test_parameter_chooses_a_pass_and_zero_begins_anew(void)
{
    bring_ready();
    set(cam_param_pass, 2);
    for (int i = 0; i < 2; i++) {
        TEST_ASSERT_EQUAL_UINT32(1, m->pass);
        cut();
    }
    set(cam_param_pass, 16);
    TEST_ASSERT_EQUAL_UINT32(2, m->pass); // the last one
    set(cam_param_pass, 0);
    TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    cam_machine_stage_begin(m); // a set of parameters chooses it as well
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage(m, cam_param_pass, 2));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_stage_commit(m));
    TEST_ASSERT_EQUAL_UINT32(1, m->pass);
}

/// A choice after the end of a pass is not overtaken by the step to the next one.
static void test_choice_or_table_after_a_pass_stands(void)
{
    for (int is_table = 0; is_table < 2; is_table++) {
        bring_ready();
        TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_start(m));
        (void)fixture_rig_until(&rig, cam_state_cutting, 400000);
        (void)fixture_rig_until(&rig, cam_state_ready, 400000);
        if (is_table != 0) {
            expect_select(cam_ok);
            fixture_rig_ticks(&rig, 3);
        } else {
            set(cam_param_pass, 0);
        }
        cam_machine_poll(m);
        TEST_ASSERT_EQUAL_UINT32(0, m->pass);
    }
}

/// Feed, speed and offset that are set apply to all passes, the offset on top of the stock.
static void test_parameters_overrule_all_passes(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, check(three, 3));
    cam_params_t params = cam_param_defaults();
    params.feed_nm = 77000;
    params.spindle_mrpm = 900000;
    params.x_trim_nm = -30000;
    for (uint32_t i = 0; i < 3; i++) {
        const cam_params_t here = cam_pass_params(&params, &table, i);
        TEST_ASSERT_EQUAL_INT32(77000, here.feed_nm);
        TEST_ASSERT_EQUAL_INT32(900000, here.spindle_mrpm);
        TEST_ASSERT_EQUAL_INT32(three[i].allowance_nm - 30000, here.x_trim_nm);
    }
    TEST_ASSERT_EQUAL_UINT32(1, cam_pass_count(NULL));
}

/// A pass that would exceed a limit refuses all, before motion, by its number.
static void test_infeasible_pass_is_refused_with_its_number(void)
{
    static const fixture_pass_t fast[3] = {
        {150000, 100000, 1200000, 0}, {20000, 100000, 3100000, 0}, {0, 100000, 2000000, 0}};
    select_passes(fast);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, cam_machine_enable(m));
    const cam_refusal_t why = cam_machine_feasibility(m);
    TEST_ASSERT_EQUAL_INT(cam_err_spindle_speed, why.err);
    TEST_ASSERT_EQUAL_UINT32(2, why.pass);
    TEST_ASSERT_EQUAL_UINT32(3100000, why.speed_mrpm);
    TEST_ASSERT_EQUAL_UINT32(3000000, cam_machine_highest_mrpm(m));
    set(cam_param_spindle_mrpm, 2500000);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_feasibility(m).err);
}

/// Where a port has no axis for the swing, its speed is none, whatever the parameter says.
static void test_a_port_without_the_swing_swings_nothing(void)
{
    const cam_params_t params = cam_param_defaults();
    hal_host_reset(20000);
    TEST_ASSERT_EQUAL_INT32(params.swing_speed_mdeg_per_s,
                            cam_pass_params(&params, NULL, 0).swing_speed_mdeg_per_s);
    cam_params_t fast = params;
    fast.swing_speed_mdeg_per_s = 1000;
    TEST_ASSERT_EQUAL_INT32(1000, cam_pass_params(&fast, NULL, 0).swing_speed_mdeg_per_s);
    hal_host.slow.has_no_swing = true;
    TEST_ASSERT_EQUAL_INT32(0, cam_pass_params(&fast, NULL, 0).swing_speed_mdeg_per_s);
    hal_host_reset(20000);
}
