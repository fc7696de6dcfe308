// SPDX-License-Identifier: Apache-2.0
#include "sim_lobe_work.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h>   // atan2, sqrt
#include <string.h> // memset

/// The eccentric disc of MATHS.md (38): radius 25, centre 5 off the axis, roller 10, wheel 200.
#define DISC_MM 25.0
#define OFFSET_MM 5.0
#define ROLLER_MM 10.0
#define WHEEL_MM 200.0
#define PHASE_RAD 0.7
#define TICKS_S 20000.0
#define TIP_MM 0.4
#define DEG (360.0 / SIM_TWO_PI)

static sim_lobe_design_t design;
static sim_work_t work;
static sim_lobe_work_t lobes;

/// An error of the motion.
typedef struct {
    double far_mm; ///< centre too far out
    double swung;  ///< share of the swing
} flaw_t;

static void begin(bool is_turned)
{
    memset(&design, 0, sizeof design);
    design.base_mm = DISC_MM - OFFSET_MM;
    design.roller_mm = ROLLER_MM;
    design.follower_mm = is_turned ? ROLLER_MM : WHEEL_MM;
    design.is_turned = is_turned;
    design.n_lobes = 1;
    design.lobe[0] = (sim_lobe_t){.z_last_mm = 12.0,
                                  .phase_rad = PHASE_RAD,
                                  .lift = {.law = sim_lobe_lift_disc,
                                           .reach_mm = DISC_MM + ROLLER_MM,
                                           .offset_mm = OFFSET_MM}};
    sim_work_init(&work, 30.1, 0.0, 12.0, true);
    sim_lobe_work_init(&lobes, &design, &work, 1, TIP_MM, 0.0);
}

/// The follower's centre runs on a circle about the disc's centre.
static double centre_mm(double phi)
{
    const double far_mm = DISC_MM + design.follower_mm;
    const double across = OFFSET_MM * sin(phi);
    return OFFSET_MM * cos(phi) + sqrt(far_mm * far_mm - across * across);
}

/// @return the angle between the line of centres and the normal, which goes through the disc's
/// centre
static double pressure_rad(double phi)
{
    return -asin(OFFSET_MM * sin(phi) / (DISC_MM + design.follower_mm));
}

/// Turn by half a turn that is not counted, then by whole turns.
static void turn_lobe(int n_turns, int ticks_per_turn, flaw_t flaw)
{
    for (int i = 0; i <= n_turns * ticks_per_turn + ticks_per_turn / 2; i++) {
        const double turn = (double)i / ticks_per_turn;
        const double phi = SIM_TWO_PI * turn - PHASE_RAD;
        const sim_lobe_tool_t tool = {.t_s = i / TICKS_S,
                                      .turn = turn,
                                      .centre_mm = centre_mm(phi) + flaw.far_mm,
                                      .swing_deg = flaw.swung * pressure_rad(phi) * DEG,
                                      .z_mm = 5.0 + 0.1 * turn,
                                      .due_rad_s = SIM_TWO_PI * TICKS_S / ticks_per_turn,
                                      .is_counted = turn >= 0.5};
        sim_lobe_work_cut(&lobes, &tool);
    }
}

/// A wheel that jumps from degree to degree would leave waves of 1 um; it is swept between them.
static void test_wheel_is_swept_between_ticks(void)
{
    begin(false);
    turn_lobe(3, 360, (flaw_t){0});
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.0, lobes.gauge[0].max_um);
}

/// The tip at r1 - tip from the swing's centre, straight below it: D - (r1 - tip) over phi. What it
/// leaves is the parallel curve of that path, far from the disc, and never too deep: the tip lies
/// inside of the roller's circle.
static void test_tool_that_does_not_swing_leaves_another_lobe(void)
{
    begin(true);
    turn_lobe(3, 20000, (flaw_t){.swung = 0.0});
    TEST_ASSERT_TRUE(lobes.gauge[0].max_um > 50.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, work.gouge_um);
}

/// Farther out by d along the line of centres: d cos(angle to the normal) along the normal.
static void test_error_of_the_wheels_distance_shows_along_the_normal(void)
{
    begin(false);
    turn_lobe(3, 20000, (flaw_t){.far_mm = 0.005});
    const double least_um = 5.0 * cos(asin(OFFSET_MM / (DISC_MM + WHEEL_MM)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 5.0, lobes.gauge[0].max_um);
    const sim_row_t *row = &work.row[sim_work_rows * 5 / 12 + 3];
    TEST_ASSERT_GREATER_THAN_UINT64(0u, row->n);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, least_um, row->min_um);
}

/// The whole disc is left of the blank: pi (blank^2 - radius^2) per millimetre fed.
static void test_removed_metal_is_the_blank_around_the_disc(void)
{
    begin(false);
    turn_lobe(4, 20000, (flaw_t){0});
    const double ring_mm2 = SIM_PI * (30.1 * 30.1 - DISC_MM * DISC_MM);
    const double turns = (double)lobes.gauge[0].n / sim_lobe_dexels;
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * ring_mm2, ring_mm2 * 0.1 * turns, work.removed_mm3);
}

/// The tool reaches a lobe in the middle of a turn: lines that it has passed half are not judged.
static void test_lobe_entered_anywhere_is_judged_where_it_was_cut(void)
{
    for (int i = 0; i < 40; i++) {
        begin(true);
        design.lobe[0].z_first_mm = 5.07 + i * 1e-5;
        turn_lobe(1, 20000, (flaw_t){.swung = 1.0});
        TEST_ASSERT_GREATER_THAN_UINT64(sim_lobe_dexels / 2u, lobes.gauge[0].n);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, lobes.gauge[0].max_um);
    }
}

/// Between two lobes a tool that stands 3 um below the base circle gouges the shaft; above it no
/// gouge is reported.
static void test_cut_below_the_base_circle_between_lobes_is_a_gouge(void)
{
    for (int is_turned = 0; is_turned < 2; is_turned++) {
        begin(is_turned != 0);
        design.lobe[1] = design.lobe[0];
        design.lobe[1].z_first_mm = 14.0;
        design.lobe[1].z_last_mm = 20.0;
        design.n_lobes = 2;
        sim_work_init(&work, 30.1, 0.0, 20.0, true);
        sim_lobe_tool_t tool = {.centre_mm = design.base_mm + design.follower_mm + 1.0,
                                .z_mm = 13.0};
        sim_lobe_work_cut(&lobes, &tool);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, work.gouge_um);
        tool.centre_mm -= 1.003;
        sim_lobe_work_cut(&lobes, &tool);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 3.0, work.gouge_um);
    }
}
