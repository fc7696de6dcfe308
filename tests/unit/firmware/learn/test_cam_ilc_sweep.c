// SPDX-License-Identifier: Apache-2.0
// Machines that are not what the controller believes: each is learned, masked or left alone, and
// none is left worse than 1.5 times what it was without learning. A few of them in an ordinary run,
// all of the thousand and more with CAM_LONG=1 in the environment.
#include "learn_plant.h"
#include "unity.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h> // getenv

enum { rehearsal_turns = 44, cut_turns = 10 };
enum { stride = 29 }; ///< no divisor of a number of values, so that all of them come

/// @return steps from one machine that is tried to the next one
static int each(void)
{
    const char *is_long = getenv("CAM_LONG");
    return is_long != NULL && *is_long == '1' ? 1 : stride;
}

/// Rehearse a machine and cut with it: its error, but for the scale's own noise, is no worse than
/// without learning. @return whether it was learned to a fifth or to noise
static bool is_learned(const learn_case_t *what, const char *of_which, int i)
{
    static learn_plant_t p;
    char name[80];
    (void)snprintf(name, sizeof name, "%s, machine %d", of_which, i);
    learn_plant_init(&p, what);
    p.setup.reason = cam_ilc_not_asked;
    learn_plant_turns(&p, cam_state_rehearsing, 4);
    const double before_um = p.rms_um;
    learn_plant_init(&p, what);
    learn_plant_turns(&p, cam_state_rehearsing, rehearsal_turns);
    double worst_um = p.rms_um;
    for (int k = 0; k < cut_turns; k++) {
        learn_plant_turns(&p, cam_state_cutting, 1);
        worst_um = fmax(worst_um, p.rms_um);
    }
    const double noise_um = 0.02 + 0.15 * what->truth.quantum_um;
    TEST_ASSERT_TRUE_MESSAGE(worst_um <= 1.5 * (before_um + noise_um), name);
    return worst_um < 0.2 * before_um || worst_um < noise_um;
}

static learn_case_t usual(void)
{
    const learn_drive_t drive = {
        .bandwidth_hz = 300.0, .damping = 0.7, .delay_us = 75.0, .quantum_um = 0.01};
    return (learn_case_t){.truth = drive,
                          .believed = drive,
                          .amplitude_mm = {0.5, 0.0, 0.5, 0.0, 0.01},
                          .rpm = 3000.0,
                          .tick_hz = 20000,
                          .polls_per_tick_q4 = 16};
}

/// Bandwidth, damping and dead time wrong: at the harmonics that are learned this spans half to
/// twice the gain and more than 80 degrees of phase to either side.
static void test_no_wrong_drive_is_made_worse(void)
{
    static const double bandwidth[] = {0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5};
    static const double damping[] = {0.5, 0.7, 1.0, 1.4, 2.0};
    static const double delay_us[] = {-75.0, -40.0, 0.0, 60.0, 150.0, 300.0};
    static const double friction[] = {0.0, 10000.0};
    uint32_t n = 0, n_learned = 0;
    learn_case_t what = usual();
    for (int i = 0; i < 8 * 5 * 6 * 2; i += each()) {
        what.believed.bandwidth_hz = 300.0 * bandwidth[i % 8];
        what.believed.damping = 0.7 * damping[i / 8 % 5];
        what.truth.delay_us = 75.0 + delay_us[i / 40 % 6];
        what.truth.friction_mm_s2 = friction[i / 240];
        n++;
        n_learned += is_learned(&what, "wrong drives", i) ? 1u : 0u;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(n * 8u / 10u, n_learned);
}

/// A mode that the scale sees, anywhere in the harmonics and beyond, weak and strong.
static void test_no_mode_is_driven(void)
{
    static const double mode_hz[] = {250.0, 400.0, 550.0, 700.0, 800.0, 1000.0, 1500.0, 2500.0};
    static const double mode_damping[] = {0.02, 0.03, 0.1};
    static const double share[] = {0.1, 0.5, 1.0};
    static const double wrong[] = {0.8, 1.2};
    learn_case_t what = usual();
    what.truth.friction_mm_s2 = 5000.0;
    for (int i = 0; i < 8 * 3 * 3 * 2 * 2; i += each()) {
        what.truth.mode_hz = mode_hz[i % 8];
        what.truth.mode_damping = mode_damping[i / 8 % 3];
        what.truth.mode_share = share[i / 24 % 3];
        what.believed.bandwidth_hz = 300.0 * wrong[i / 72 % 2];
        what.truth.quantum_um = i / 144 == 0 ? 0.01 : 1.0;
        (void)is_learned(&what, "modes", i);
    }
}

/// A slow side that takes only some of the turns, a scale that is late, other speeds.
static void test_no_latency_makes_it_worse(void)
{
    static const double rpm[] = {600.0, 1500.0, 2500.0, 3000.0, 4500.0, 6000.0};
    static const double latency_us[] = {0.0, 20.0, 50.0};
    static const uint32_t slow[] = {1, 3, 4};
    static const double wrong[] = {0.7, 0.9, 1.3};
    learn_case_t what = usual();
    for (int i = 0; i < 6 * 3 * 3 * 3; i += each()) {
        what.rpm = rpm[i % 6];
        what.amplitude_mm[2] = 0.5 * 3000.0 / (what.rpm > 3000.0 ? what.rpm : 3000.0);
        what.believed.latency_us = latency_us[i / 6 % 3];
        what.truth.latency_us = latency_us[i / 6 % 3];
        what.slow_turns = slow[i / 18 % 3];
        what.believed.bandwidth_hz = 300.0 * wrong[i / 54];
        (void)is_learned(&what, "latencies and speeds", i);
    }
}

/// Drives of other kinds, from a slow one to a piezo.
static void test_no_other_drive_is_made_worse(void)
{
    static const double bandwidth_hz[] = {120.0, 200.0, 300.0, 500.0, 1000.0};
    static const double damping[] = {0.3, 0.7, 1.0};
    static const double wrong[] = {0.7, 0.85, 1.15, 1.4};
    static const double delay[] = {0.5, 2.0};
    learn_case_t what = usual();
    for (int i = 0; i < 5 * 3 * 4 * 2; i += each()) {
        what.truth.bandwidth_hz = bandwidth_hz[i % 5];
        what.truth.damping = damping[i / 5 % 3];
        what.believed = what.truth;
        what.believed.bandwidth_hz *= wrong[i / 15 % 4];
        what.believed.delay_us *= delay[i / 60];
        (void)is_learned(&what, "other drives", i);
    }
}
