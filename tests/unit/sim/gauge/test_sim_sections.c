// SPDX-License-Identifier: Apache-2.0
#include "sim_work.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // cos, fabs, floor, isnan

#define FEED_MM 0.1
#define LAST_MM 4.0

static sim_sections_t s;
static const double heights_mm[] = {0.55, 2.0, 3.333};

void setUp(void)
{
    sim_sections_init(&s, heights_mm, 3, 0.0, LAST_MM);
}

/// The surface that the tool leaves: waves that grow along the height, in closed form.
static double surface_mm(double turn, double z_mm)
{
    const double phi = SIM_TWO_PI * turn;
    return 1e-3 * (2.0 + 0.5 * z_mm + 0.7 * cos(3.0 * phi) + 0.2 * z_mm * sin(50.0 * phi));
}

/// Cut a helix; ticks are uneven as those of a spindle with ripple.
/// @param sense  1 (M3) or -1 (M4)
static void cut_helix(double from_turn, double to_turn, int sense)
{
    const double per_turn = 480.0;
    for (int i = 0; i <= (int)((to_turn - from_turn) * per_turn); i++) {
        const double even = from_turn + i / per_turn;
        const double turned = even + 2e-4 * cos(SIM_TWO_PI * even);
        const double z_mm = FEED_MM * turned;
        sim_sections_touch(&s, sense * turned, z_mm, surface_mm(sense * turned, z_mm), true);
    }
}

/// The whole section against the closed form: 0.4 % of the fifty waves, nothing of the rest.
static void test_section_of_a_helix_is_the_surface_in_both_senses(void)
{
    for (int row = 0; row < 6; row++) {
        const int i = row / 2;
        double worst_mm = 0.0;
        setUp();
        cut_helix(0.0, 40.0, row % 2 == 0 ? 1 : -1);
        for (int k = 0; k < sim_sections_places; k++) {
            const double turn = (double)k / sim_sections_places;
            const double off_mm = fabs(s.section[i][k].e_mm - surface_mm(turn, heights_mm[i]));
            worst_mm = !(off_mm <= worst_mm) ? off_mm : worst_mm; // NAN is no good
        }
        const double waves_mm = 0.2e-3 * heights_mm[i];
        TEST_ASSERT_DOUBLE_WITHIN(0.0043 * waves_mm + 1e-9, 0.0, worst_mm);
        TEST_ASSERT_TRUE(worst_mm > 0.001 * waves_mm); // they are there, and interpolated
    }
}

static void test_lines_follow_the_height_at_four_angles(void)
{
    cut_helix(0.0, 40.0, 1);
    for (int line = 0; line < sim_sections_lines; line++) {
        int n = 0;
        for (int i = 0; i < sim_sections_heights; i++) {
            const double z_mm = sim_sections_height_mm(&s, i);
            const double e_mm = s.line_e_mm[line][i];
            TEST_ASSERT_DOUBLE_WITHIN(1e-12, LAST_MM * i / (sim_sections_heights - 1), z_mm);
            if (!isnan(e_mm)) {
                TEST_ASSERT_DOUBLE_WITHIN(1e-6, surface_mm(0.25 * line, z_mm), e_mm);
                n++;
            }
        }
        // All heights but those of the first turn, before the first and after the last pass.
        TEST_ASSERT_TRUE(n > sim_sections_heights * 94 / 100);
    }
}

/// Heights without a track below or above, and tracks apart by an interruption, are empty.
static void test_section_needs_tracks_on_both_sides(void)
{
    cut_helix(6.0, 19.5, 1); // 0.6 .. 1.95 mm
    for (int k = 0; k < sim_sections_places; k++) {
        TEST_ASSERT_TRUE(isnan(s.section[0][k].e_mm));
        TEST_ASSERT_TRUE(isnan(s.section[1][k].e_mm));
    }
    setUp();
    cut_helix(0.0, 15.0, 1);
    sim_sections_touch(&s, 15.1, 1.5, 0.0, false);
    cut_helix(25.0, 30.0, 1);
    TEST_ASSERT_FALSE(isnan(s.section[0][1000].e_mm));
    TEST_ASSERT_TRUE(isnan(s.section[1][1000].e_mm));
    setUp();
    sim_sections_init(&s, heights_mm, 0, 0.0, LAST_MM); // nothing is asked for
    cut_helix(0.0, 3.0, 1);
    TEST_ASSERT_TRUE(isnan(s.line_e_mm[0][50]));
}

/// A ring-helix comes to a height and stays there for a turn: its track is the section itself.
static void test_ring_at_the_height_is_taken_as_it_is(void)
{
    for (int i = 0; i < 480 * 2; i++) {
        sim_sections_touch(&s, i / 480.0, 2.0, surface_mm(i / 480.0, 2.0), true);
    }
    for (int k = 0; k < sim_sections_places; k++) {
        const double exact_mm = surface_mm((double)k / sim_sections_places, 2.0);
        TEST_ASSERT_DOUBLE_WITHIN(0.0043 * 0.4e-3, exact_mm, s.section[1][k].e_mm);
    }
}

static void test_spindle_that_turns_back_leaves_numbers(void)
{
    cut_helix(0.0, 5.0, 1);
    const double there[] = {5.001, 5.004, 5.003, 5.0031, 5.006, 5.006, 5.007, 5.009};
    for (int i = 0; i < 8; i++) {
        sim_sections_touch(&s, there[i], 0.5, 1e-3, true);
    }
    cut_helix(5.01, 12.0, 1);
    for (int k = 0; k < sim_sections_places; k++) {
        TEST_ASSERT_TRUE(fabs(s.section[0][k].e_mm) < 0.01);
    }
}

/// A window of 30 degrees, from 1 to 3 mm: nothing in it, nothing across it, all beside it.
static void test_window_is_not_bridged(void)
{
    const double per_turn = 480.0;
    for (int i = 0; i <= (int)(40.0 * per_turn); i++) {
        const double turn = i / per_turn;
        const double z_mm = FEED_MM * turn;
        const double place = turn - floor(turn);
        if (place > 0.25 && place < 0.25 + 30.0 / 360.0 && z_mm > 1.0 && z_mm < 3.0) {
            sim_sections_skip(&s, turn);
        } else {
            sim_sections_touch(&s, turn, z_mm, surface_mm(turn, z_mm), true);
        }
    }
    for (int k = 0; k < sim_sections_places; k++) {
        const double turn = (double)k / sim_sections_places;
        const bool is_in = turn > 0.25 && turn < 0.25 + 30.0 / 360.0;
        const bool is_beside =
            turn > 0.25 - 2.1 / per_turn && turn < 0.25 + 30.0 / 360.0 + 2.1 / per_turn;
        const double e_mm = s.section[1][k].e_mm;
        if (is_in) {
            TEST_ASSERT_TRUE(isnan(e_mm));
        } else if (!is_beside || !isnan(e_mm)) {
            TEST_ASSERT_DOUBLE_WITHIN(0.0043 * 0.4e-3 + 1e-9, surface_mm(turn, 2.0), e_mm);
        }
        TEST_ASSERT_FALSE(isnan(s.section[0][k].e_mm)); // below the window
        TEST_ASSERT_FALSE(isnan(s.section[2][k].e_mm)); // above it
    }
}
