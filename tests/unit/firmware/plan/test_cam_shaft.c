// SPDX-License-Identifier: Apache-2.0
// Which lobe is played: it changes only while U rests on the base circle, with its phase. A
// measured Z finds it too, and stations let Z stand at the lobes.
#include "cam_build.h"
#include "cam_eval.h"
#include "cam_plan_inner.h" // cam_shaft_share, cam_shaft_t, cam_shaft_begin_isr
#include "fixture_newer.h"
#include "fixture_play.h"
#include "fixture_shaft.h"
#include "unity.h"
#include <math.h> // fabs, ldexp

#define ONE (INT32_C(1) << 30)

static fixture_play_t f;
static fixture_image_t image;
static cam_table_t table;
static cam_shaft_t shaft;
static cam_motion_t motion;

void setUp(void)
{
    const fixture_shaft_t three = fixture_shaft_three();
    fixture_shaft_make(&image, &three);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    shaft = (cam_shaft_t){0};
    motion = (cam_motion_t){.phase_q32 = 1000};
    cam_shaft_begin_isr(&shaft, &table, 0, &motion);
}

/// Without a speed channel the lift alone changes; with one, one of both always rests.
static void test_shares_fall_by_smooth_steps(void)
{
    for (int32_t i = 0; i <= 1000; i++) {
        const int32_t s_q31 = (int32_t)(INT64_C(2147483647) * i / 1000);
        const cam_share_t alone = cam_shaft_share(s_q31, false);
        TEST_ASSERT_TRUE(
            fabs(ldexp(alone.lift_q30, -30) - (1.0 - fixture_play_smooth(i / 1000.0))) < 2e-7);
        TEST_ASSERT_EQUAL_INT32(ONE, alone.ratio_q30);
        const cam_share_t both = cam_shaft_share(s_q31, true);
        TEST_ASSERT_TRUE(both.lift_q30 == 0 || both.ratio_q30 == ONE);
        const double lift = 1.0 - fixture_play_smooth(i / 500.0);
        const double ratio = 1.0 - fixture_play_smooth(i / 500.0 - 1.0);
        TEST_ASSERT_TRUE(fabs(ldexp(both.lift_q30, -30) - lift) < 2e-7);
        TEST_ASSERT_TRUE(fabs(ldexp(both.ratio_q30, -30) - ratio) < 2e-7);
    }
    TEST_ASSERT_EQUAL_INT32(ONE, cam_shaft_share(0, false).lift_q30);
    TEST_ASSERT_EQUAL_INT32(0, cam_shaft_share(INT32_MAX, false).lift_q30);
    TEST_ASSERT_EQUAL_INT32(0, cam_shaft_share(INT32_MAX, true).ratio_q30);
}

static void test_first_lobe_is_taken_at_the_first_height(void)
{
    TEST_ASSERT_EQUAL_INT32(1000, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(INT64_C(0x1FFFFFFFE), motion.height_q32); // pattern 2: all of it
    motion.height_step_q32 = 7;                                       // of a motion before
    cam_shaft_begin_isr(&shaft, &table, 700000, &motion);
    TEST_ASSERT_EQUAL_INT32(0, motion.height_step_q32);
    TEST_ASSERT_EQUAL_UINT32(2, shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT64(INT64_C(1) << 32, motion.height_q32);
}

static void test_lobe_changes_only_at_amplitude_0(void)
{
    motion.scale_q30 = 5;
    cam_share_t share = cam_shaft_plan_isr(&shaft, &table, 390000, &motion);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(0, shaft.i_lobe, "still on its way down");
    TEST_ASSERT_EQUAL_INT32(0, share.lift_q30);
    TEST_ASSERT_EQUAL_INT32(1000, motion.phase_q32);
    motion.scale_q30 = 0;
    share = cam_shaft_plan_isr(&shaft, &table, 390000, &motion);
    TEST_ASSERT_EQUAL_UINT32(1, shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT32(ONE, share.lift_q30);
    TEST_ASSERT_EQUAL_INT32(1000 + 0x40000000, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(0, motion.height_q32);
    (void)cam_shaft_plan_isr(&shaft, &table, 900000, &motion);
    TEST_ASSERT_EQUAL_UINT32(2, shaft.i_lobe);
    TEST_ASSERT_EQUAL_UINT32(0xC0000000u + 1000u, (uint32_t)motion.phase_q32);
}

static void test_table_without_lobes_is_left_alone(void)
{
    const cam_motion_t before = {.phase_q32 = 7, .height_q32 = 99, .scale_q30 = 0};
    table.n_lobes = 0;
    motion = before;
    cam_shaft_begin_isr(&shaft, &table, 500000, &motion);
    TEST_ASSERT_EQUAL_INT32(7, motion.phase_q32);
    TEST_ASSERT_EQUAL_INT64(99, motion.height_q32);
    TEST_ASSERT_EQUAL_UINT32(0, shaft.phase_q32);
}

/// A ramp without lag, a step of noise as an eighth of it at most, a start within its bound.
static void test_measured_height_is_smoothed(void)
{
    cam_shaft_begin_isr(&shaft, &table, 0, &motion);
    int32_t most_nm = 0;
    for (int32_t i = 1; i <= 400; i++) {
        const int32_t off_nm = 1000 * i - cam_shaft_smooth_isr(&shaft, 1000 * i);
        most_nm = off_nm > most_nm ? off_nm : most_nm;
        TEST_ASSERT_TRUE(i < 200 || (off_nm <= 2 && off_nm >= -2));
    }
    TEST_ASSERT_INT32_WITHIN(100, 5200, most_nm);
    cam_shaft_begin_isr(&shaft, &table, 5000, &motion);
    TEST_ASSERT_INT32_WITHIN(1, 5001, cam_shaft_smooth_isr(&shaft, 5010));
    cam_shaft_begin_isr(&shaft, &table, 5000, &motion); // it begins without the speed before
    TEST_ASSERT_EQUAL_INT32(5000, cam_shaft_smooth_isr(&shaft, 5000));
    TEST_ASSERT_EQUAL_INT64(5000 * 256, shaft.z_q8);
}

/// Play the image in the bench.
static void play(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_play_init(&f, &part);
    f.image = image;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    fixture_play_configure(&f);
}

/// Without stations a measured Z finds the lobe, and is smoothed for it: one plan follows an eighth
/// of a jump.
static void test_a_measured_z_finds_the_lobe(void)
{
    play();
    fixture_play_measure_z(&f, 0);
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    TEST_ASSERT_EQUAL_UINT32(0, f.plan.shaft.i_lobe);
    while (f.in.actual_nm[hal_axis_z] < 800000) {
        f.in.actual_nm[hal_axis_z] += 100;
        fixture_play_tick(&f);
    }
    TEST_ASSERT_EQUAL_UINT32(2, f.plan.shaft.i_lobe);
    TEST_ASSERT_EQUAL_INT(cam_state_cutting, f.want.state);
    TEST_ASSERT_INT64_WITHIN(20000 * 256, 800000 * 256, f.plan.shaft.z_q8); // by the lead of a plan
    double lift[3];
    play();
    fixture_play_measure_z(&f, 260000); // where the lift changes between two lobes
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    fixture_play_ticks(&f, 100 * FIXTURE_PLAN_TICKS);
    for (int i = 0; i < 3; i++) { // before the jump, after a plan, after all
        f.in.actual_nm[hal_axis_z] += i == 1 ? 4000 : 0;
        do {
            fixture_play_ticks(&f, i == 2 ? 100 * FIXTURE_PLAN_TICKS : 1);
        } while (f.until_plan != f.config.play.plan_ticks);
        const cam_motion_t *m = &f.motion;
        lift[i] = ldexp(m->scale_q30 + (double)m->scale_step_q30 * FIXTURE_PLAN_TICKS, -30);
    }
    TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    TEST_ASSERT_TRUE(fabs(lift[2] - lift[0]) > 0.01);
    TEST_ASSERT_TRUE(fabs(lift[1] - lift[0]) < 0.4 * fabs(lift[2] - lift[0]));
}

static double slope; ///< of Z over the station

static void straight(double z_nm, double w[3])
{
    w[0] = (slope - 1.0) * z_nm;
    w[1] = slope - 1.0;
    w[2] = 0.0;
}

/// Check the image with a straight way and a value of its path.
static cam_err_t with_way(bool is_shaft, double slope_, uint32_t path)
{
    const fixture_shaft_t three = fixture_shaft_three();
    const fixture_part_t skirt = fixture_part_short();
    slope = slope_;
    fixture_shaft_make(&image, &three);
    if (!is_shaft) {
        fixture_image_make(&image, &skirt);
    }
    fixture_newer_way(&image, straight, 15, 4);
    const uint32_t way = fixture_newer_last(&image);
    fixture_image_put(&image, fixture_image_in(way, fixture_in_path), path);
    fixture_image_seal(&image);
    return cam_table_check(image.bytes, image.size, &table);
}

/// The way of a shaft has stations, and does not end below its start; a skirt may have stations.
static void test_shafts_and_skirts_have_stations(void)
{
    static const struct {
        bool is_shaft;
        double slope;
        uint32_t path;
        cam_err_t err;
    } rows[] = {{true, 0.0, 0, cam_err_image_channel},
                {true, 0.0, 2, cam_err_image_channel},
                {true, -0.01, 1, cam_err_image_channel},
                {false, 0.0, 1, cam_ok},
                {true, 1.5, 1, cam_ok},
                {true, 0.0, 1, cam_ok}};
    for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        TEST_ASSERT_EQUAL_INT(rows[i].err, with_way(rows[i].is_shaft, rows[i].slope, rows[i].path));
        if (rows[i].err == cam_ok) {
            TEST_ASSERT_INT32_WITHIN(1, (int32_t)(rows[i].slope * 1e6),
                                     cam_feed_profile_z_last_nm(&table));
        }
    }
    TEST_ASSERT_TRUE(table.has_stations && !table.is_ring_helix);
    for (int32_t s_nm = 0; s_nm <= 1000000; s_nm += 9973) {
        TEST_ASSERT_INT32_WITHIN(1, 0, cam_feed_profile_at(&table, s_nm).z_nm);
    }
}

static void test_range_of_z_ends_where_z_does(void)
{
    static cam_config_t config;
    const cam_params_t params = cam_param_defaults();
    TEST_ASSERT_EQUAL_INT(cam_ok, with_way(true, 0.5, 1));
    TEST_ASSERT_EQUAL_INT(cam_ok,
                          cam_build_config(&config, &params, &table, 3000000, 20000, 20000).err);
    TEST_ASSERT_INT32_WITHIN(1, 500000 + params.z_margin_nm, config.play.z_high_nm);
    TEST_ASSERT_EQUAL_INT32(-params.z_margin_nm, config.play.z_low_nm);
}

/// All lobes are cut while Z stands: the helix finds the lobe, the way gives Z.
static void test_z_stands_while_one_lobe_after_the_other_is_cut(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, with_way(true, 0.0, 1));
    play();
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    TEST_ASSERT_EQUAL_INT64(INT64_C(0x1FFFFFFFE), f.motion.height_q32); // pattern 2: all of it
    uint32_t seen = 0;
    for (uint32_t i = 0; i < 100000u && f.want.state == cam_state_cutting; i++) {
        fixture_play_tick(&f);
        seen |= 1u << f.plan.shaft.i_lobe;
        TEST_ASSERT_EQUAL_INT64(0, f.axis[hal_axis_z].pos_q10);
    }
    TEST_ASSERT_EQUAL_INT(cam_state_disengaging, f.want.state);
    TEST_ASSERT_EQUAL_HEX32(7, seen);
}
