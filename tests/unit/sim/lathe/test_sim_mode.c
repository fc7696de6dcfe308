// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_config.h"
#include "sim_units.h" // SIM_TWO_PI
#include "unity.h"
#include <math.h> // cos, sin, sqrt

#define STEP_S 50e-6
#define SWING 1e5

static sim_mode_config_t config;
static sim_mode_t mode;

void setUp(void)
{
    config = sim_config_defaults().lathe.mode[0];
    config.hz = 800.0;
}

/// Let the slide swing until the mode has settled; return the largest tip after that.
static double settled_tip(double hz)
{
    const double f = SIM_TWO_PI * hz;
    double largest = 0.0;
    sim_mode_init(&mode, &config);
    for (int i = 0; i < 4000; i++) {
        const double a = f * i * STEP_S;
        const double b = f * (i + 1) * STEP_S;
        const sim_mode_travel_t way = {{SWING * sin(a), SWING * sin(b)},
                                       {SWING * f * cos(a), SWING * f * cos(b)}};
        sim_mode_step(&mode, &way, STEP_S);
        const double tip = fabs(sim_mode_tip_micro(&mode));
        largest = i > 2000 && tip > largest ? tip : largest;
    }
    return largest;
}

/// share f^2 / |w^2 - f^2 + 2 j d w f| of the swing, the amplitude of a base-excited oscillator.
static void test_tip_swings_as_the_frequency_response_says(void)
{
    static const double at_hz[] = {37.0, 101.0, 433.0, 800.0, 1117.0};
    config.share = 0.7;
    for (int i = 0; i < 5; i++) {
        const double r = at_hz[i] / config.hz;
        const double real = 1.0 - r * r;
        const double imaginary = 2.0 * config.damping * r;
        const double wanted =
            SWING * config.share * r * r / sqrt(real * real + imaginary * imaginary);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * wanted, wanted, settled_tip(at_hz[i]));
    }
    config.hz = 0.0; // without a frequency there is no mode
    TEST_ASSERT_TRUE(settled_tip(100.0) == 0.0);
}

static void test_pieces_make_the_same_way_as_the_whole(void)
{
    sim_mode_t whole;
    sim_mode_init(&mode, &config);
    sim_mode_init(&whole, &config);
    const sim_mode_travel_t first = {{0.0, 10.0 + 1.5},
                                     {0.0, 1e6}}; // x = 1e6 t + cubic by its ends
    sim_mode_step(&mode, &first, STEP_S);
    sim_mode_step(&whole, &first, STEP_S);
    const sim_mode_travel_t rest = {{11.5, 11.5 + 1e6 * 30e-6}, {1e6, 1e6}};
    const sim_mode_travel_t half = {{11.5, 11.5 + 1e6 * 12e-6}, {1e6, 1e6}};
    const sim_mode_travel_t other = {{half.pos_micro[1], rest.pos_micro[1]}, {1e6, 1e6}};
    sim_mode_step(&whole, &rest, 30e-6);
    sim_mode_step(&mode, &half, 12e-6);
    sim_mode_step(&mode, &other, 18e-6);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, whole.pos_micro, mode.pos_micro);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, whole.vel_micro_per_s, mode.vel_micro_per_s);
}
