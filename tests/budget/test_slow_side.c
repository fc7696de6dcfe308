// SPDX-License-Identifier: Apache-2.0
// Instructions of the slow side: each piece of learning and all of a turn, a feasibility check.
#include "budget.h"
#include "budget_count.h"
#include "cam_feasible.h"
#include "cam_learning_inner.h" // cam_cos_q24
#include "fixture_image.h"
#include "unity.h"
#include <stdio.h>

enum { ticks_per_turn = 400, n_turns = 60 };

static cam_ilc_t ilc;
static cam_turn_bins_t bins;
static cam_learned_t learned;
static int64_t pos_q32;
static uint32_t tick, generation;
static uint32_t most_piece, most_turn, in_turn;

static const cam_ilc_setup_t setup = {
    .angle_step_q23 = INT16_MAX,
    .observer_step_q23 = INT16_MAX,
    .n_harmonics = cam_ilc_harmonics,
    .gain_q16 = 1 << 15,
    .cut_gain_q16 = 9830,
    .probe_q6 = 64000,
    .ripple_turns = 2,
    .scale_nm = 10,
    .most_q6 = cam_ilc_most_nm * 64,
    .k1_q16 = 15 << 16,
    .k2_q16 = 113 << 16,
    .k1_least_q16 = -(20 << 16),
    .k2_least_q16 = -(130 << 16),
    .k1_most_q16 = 20 << 16,
    .k2_most_q16 = 130 << 16,
    .between_q16 = 8192,
    .eccentricity = {.re = 4096},
};

static int32_t wave(uint32_t k, uint32_t at_q32)
{
    return cam_cos_q24(k * (at_q32 >> 24)) >> 4;
}

static void count(uint32_t from)
{
    const uint32_t n = budget_instructions(from, budget_count());
    most_piece = n > most_piece ? n : most_piece;
    in_turn += n;
}

static void piece(cam_state_t state)
{
    const uint32_t at_q8 = (uint32_t)((uint64_t)pos_q32 >> 24);
    const uint32_t from = budget_count();
    cam_ilc_poll(&ilc, &setup, state, &bins);
    count(from);
    if (cam_ilc_is_blending(&ilc, at_q8)) {
        const uint32_t begin = budget_count();
        cam_ilc_blend(&ilc, &setup, at_q8, &learned);
        count(begin);
        generation++;
    }
}

/// A turn with an error in every harmonic, so that everything has to move.
static void play_turn(cam_state_t state)
{
    const int32_t speed_q32 = (int32_t)(CAM_TURN_Q32 / ticks_per_turn);
    in_turn = 0;
    for (int i = 0; i < ticks_per_turn; i++) {
        const uint32_t at_q32 = cam_angle_of_pos(pos_q32);
        int32_t error_nm = 0;
        for (uint32_t k = 1; k < cam_ilc_terms; k++) {
            error_nm += wave(k, at_q32) >> 11;
        }
        const int32_t u_nm = wave(2, at_q32) / 2;
        const cam_tick_record_t r = {.config = generation,
                                     .in.actual_nm = {u_nm - error_nm},
                                     .angle = {.pos_q32 = pos_q32,
                                               .measured_q32 = at_q32 + (uint32_t)wave(5, at_q32),
                                               .speed_q32 = speed_q32},
                                     .want = {.state = state, .u_due_q6 = u_nm * 64}};
        cam_turn_bins_add_isr(&bins, &r);
        if (tick % 8u == 0u) {
            const cam_motion_t m = {.is_playing = true, .scale_q30 = 1 << 30};
            cam_turn_bins_plan_isr(&bins, &r, &m);
        }
        piece(state);
        pos_q32 += speed_q32;
        tick++;
    }
    most_turn = in_turn > most_turn ? in_turn : most_turn;
}

static void test_pieces_and_turns_fit_their_budgets(void)
{
    budget_count_start();
    cam_ilc_init(&ilc);
    for (int turn = 0; turn < n_turns; turn++) {
        play_turn(turn < n_turns / 2 ? cam_state_rehearsing : cam_state_cutting);
    }
    printf("figure learn_piece %lu\nfigure learn_turn %lu\n", (unsigned long)most_piece,
           (unsigned long)most_turn);
    TEST_ASSERT_GREATER_THAN_UINT32(10, ilc.n_turns);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_learn_piece, most_piece);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_learn_turn, most_turn);
}

/// The verdict on a cut with every limit, as before each start.
static void test_feasibility_check(void)
{
    static fixture_image_t image;
    static cam_table_t table;
    const fixture_part_t part = fixture_part_short();
    const cam_params_t params = cam_param_defaults();
    fixture_image_make(&image, &part);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_table_check(image.bytes, image.size, &table));
    budget_count_start();
    const uint32_t from = budget_count();
    const cam_err_t err = cam_feasible_check(&table, &params, 1000000, 20000);
    const uint32_t n = budget_instructions(from, budget_count());
    printf("figure feasibility_check %lu\n", (unsigned long)n);
    TEST_ASSERT_EQUAL_INT(cam_ok, err);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(budget_feasibility_check, n);
}
