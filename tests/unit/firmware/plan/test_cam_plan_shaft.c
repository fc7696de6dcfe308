// SPDX-License-Identifier: Apache-2.0
// A shaft of lobes whose Z others move: what its noise does to the lift between two lobes.
#include "fixture_play.h"
#include "fixture_shaft.h"
#include "unity.h"
#include <math.h>

/// [nm] where the lift changes between the first lobe, which ends at 200 um, and the second.
enum { between_nm = 260000, jump_nm = 4000 };

static fixture_play_t f;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    const fixture_shaft_t shaft = fixture_shaft_three();
    fixture_play_init(&f, &part);
    fixture_shaft_make(&f.image, &shaft);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(f.image.bytes, f.image.size, &f.table));
    f.params.z_is_measured = 1;
    fixture_play_configure(&f);
    f.is_axes_held = true;
    f.in.actual_nm[hal_axis_z] = between_nm;
    TEST_ASSERT_TRUE(fixture_play_bring(&f, cam_state_cutting));
    fixture_play_ticks(&f, 100 * FIXTURE_PLAN_TICKS);
}

/// @return [1] lift at which the present plan arrives
static double lift(void)
{
    const cam_motion_t *m = &f.motion;
    return ldexp(m->scale_q30 + (double)m->scale_step_q30 * f.config.play.plan_ticks, -30);
}

/// Run up to behind the next plan.
static void plan(void)
{
    do {
        fixture_play_tick(&f);
    } while (f.until_plan != f.config.play.plan_ticks);
}

/// A place that jumps is followed within some plans, and one of them takes an eighth of it.
static void test_lift_follows_a_jump_of_the_measured_height_smoothly(void)
{
    const double before = lift();
    f.in.actual_nm[hal_axis_z] += jump_nm;
    plan();
    const double first = lift();
    for (int i = 0; i < 100; i++) {
        plan();
    }
    const double last = lift();
    TEST_ASSERT_EQUAL_HEX32(0, f.want.faults);
    TEST_ASSERT_TRUE(fabs(last - before) > 0.01);
    TEST_ASSERT_TRUE(fabs(first - before) < 0.4 * fabs(last - before));
}
