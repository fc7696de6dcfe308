// SPDX-License-Identifier: Apache-2.0
// What the interrupt gathers of a turn, who may touch its bins when, and tables between knots.
#include "cam_record.h"
#include "cam_config.h"
#include "fixture_random.h"
#include "unity.h"
#include <math.h>
#include <string.h>

enum { ticks_per_turn = 400, plan_ticks = 8 };

static cam_turn_bins_t g;
static cam_tick_record_t record;
static cam_motion_t motion;
static cam_turn_t turn;
static int64_t pos_q32;
static uint32_t n_ticks;

void setUp(void)
{
    memset(&g, 0, sizeof g);
    record = (cam_tick_record_t){
        .in.actual_nm = {-310},
        .want = {.state = cam_state_rehearsing, .u_due_q6 = -64 * 300 + 5},
    };
    motion = (cam_motion_t){.is_playing = true, .scale_q30 = 1 << 30};
    pos_q32 = 0;
    n_ticks = 0;
}

/// One tick at a uniform speed; the encoder reads a thousandth of a turn too much.
static void tick(int32_t step_q32)
{
    pos_q32 += step_q32;
    record.tick = n_ticks;
    record.angle.pos_q32 = pos_q32;
    record.angle.measured_q32 = cam_angle_of_pos(pos_q32) + UINT32_C(4294967);
    cam_turn_bins_add_isr(&g, &record);
    if (++n_ticks % plan_ticks == 0u) {
        record.angle.speed_q32 = step_q32;
        record.want.z_nm += 10;
        cam_turn_bins_plan_isr(&g, &record, &motion);
    }
}

static void turn_on(double turns)
{
    const int64_t to_q32 = pos_q32 + llround(turns * 4294967296.0);
    while (pos_q32 < to_q32) {
        tick((int32_t)(CAM_TURN_Q32 / ticks_per_turn) + 1);
    }
}

/// Let the slow side look in until a turn is taken. @return its bins, NULL after three turns
static const cam_turn_bin_t *take_next(void)
{
    const cam_turn_bin_t *bins = NULL;
    for (int i = 0; i < 24 && bins == NULL; i++) {
        turn_on(0.125);
        bins = cam_turn_bins_take(&g, &turn);
    }
    return bins;
}

/// Turns are numbered modulo 2^24: behind the last number the first one follows as any other.
static void test_turns_go_on_behind_the_last_number(void)
{
    pos_q32 = ((INT64_C(1) << 24) - 4) * CAM_TURN_Q32;
    uint32_t next = 0;
    for (int i = 0; i < 6; i++) {
        TEST_ASSERT_NOT_NULL(take_next());
        TEST_ASSERT_TRUE(i == 0 || turn.turn == next);
        TEST_ASSERT_TRUE(turn.is_steady);
        next = (turn.turn + 1u) & 0xFFFFFFu;
        TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
    }
    TEST_ASSERT_LESS_THAN_UINT32(10, next);
}

static void test_tables_are_linear_between_knots(void)
{
    int16_t table[cam_learned_points + 2];
    fixture_random_t random = {1};
    for (int i = 0; i < cam_learned_points; i++) {
        table[i] = (int16_t)fixture_random_u32(&random);
    }
    table[0] = INT16_MIN; // the extremes side by side
    table[1] = INT16_MAX;
    table[cam_learned_points] = table[0];
    table[cam_learned_points + 1] = table[1];
    for (int i = 0; i < 20000; i++) {
        const uint32_t theta_q32 = i == 0 ? UINT32_MAX : fixture_random_u32(&random);
        const double at = floor(theta_q32 / 65536.0) / 256.0; // [knots] the angle's upper 16 bits
        const int knot = (int)at;
        const double exact = table[knot] + (at - knot) * ((double)table[knot + 1] - table[knot]);
        const cam_learned_place_t place = cam_learned_place(theta_q32);
        TEST_ASSERT_EQUAL_INT32(lround(exact * 256.0), cam_learned_at_q8(table, place));
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(int32_t)lround(exact * 512.0),
                                 cam_learned_turn_q32(table, place));
        const double next =
            table[knot + 1] + (at - knot) * ((double)table[knot + 2] - table[knot + 1]);
        TEST_ASSERT_EQUAL_INT32(lround((next - exact) * 256.0),
                                cam_learned_faster_q23(table, place));
    }
}

static void test_a_turn_is_gathered_whole_and_alone(void)
{
    const cam_turn_bin_t *bins = NULL;
    uint32_t last = 0;
    motion.phase_q32 = 77;
    motion.axis[hal_axis_z].vel_q10 = 5;
    for (int i = 0; i < 5; i++) {
        bins = take_next();
        TEST_ASSERT_NOT_NULL(bins);
        TEST_ASSERT_TRUE(i == 0 || turn.turn == last + 1u);
        last = turn.turn;
        uint32_t n = 0;
        for (uint32_t k = 0; k < cam_turn_bins_n; k++) {
            const int32_t ticks = (int32_t)bins[k].n;
            TEST_ASSERT_INT_WITHIN(1, 3, ticks);
            TEST_ASSERT_EQUAL_INT32(ticks * (64 * 10 + 5), bins[k].error_q6);
            TEST_ASSERT_EQUAL_INT32(ticks * -300, bins[k].u_nm);
            const double mean_q24 = (double)bins[k].angle_q24 / ticks;
            TEST_ASSERT_DOUBLE_WITHIN(65536.0, 16777.0 + 65536.0, mean_q24);
            n += (uint32_t)bins[k].n;
        }
        TEST_ASSERT_UINT32_WITHIN(1, ticks_per_turn, n);
        TEST_ASSERT_TRUE(turn.is_steady);
        TEST_ASSERT_INT32_WITHIN(10, 490, turn.z_end_nm - turn.z_begin_nm); // 49 or 50 plans
        TEST_ASSERT_EQUAL_INT(cam_state_rehearsing, turn.state);
        TEST_ASSERT_EQUAL_INT32(1 << 30, turn.scale_q30);
        TEST_ASSERT_EQUAL_INT32(77, turn.phase_q32);
        TEST_ASSERT_EQUAL_INT32(5, g.z_vel_q10);
        TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
    }
}

/// The mean measured angle of a bin is that of its ticks, which a sum of bins of one tick each
/// shows: there the angle is that of the tick.
static void test_the_angle_is_counted_from_the_begin_of_the_bin(void)
{
    record.angle.pos_q32 = 5 * CAM_TURN_Q32 + 3 * (CAM_TURN_Q32 / 128) + 256 * 11;
    record.angle.measured_q32 = (uint32_t)(3 * (CAM_TURN_Q32 / 128)) - 256u * 5u;
    cam_turn_bins_add_isr(&g, &record);
    TEST_ASSERT_EQUAL_INT32(-5, g.bin[128 + 3].angle_q24);
    TEST_ASSERT_EQUAL_UINT32(1, g.bin[128 + 3].n);
    record.angle.pos_q32 = -1; // the last bin of turn -1, an odd one
    record.angle.measured_q32 = 0;
    cam_turn_bins_add_isr(&g, &record);
    TEST_ASSERT_EQUAL_UINT32(1, g.bin[255].n);
    TEST_ASSERT_EQUAL_INT32(131072, g.bin[255].angle_q24);
}

/// The phase or the state moves, or nothing is played; an amplitude that moves is not level.
static void test_a_turn_in_motion_is_not_steady(void)
{
    for (int i = 0; i < 4; i++) {
        setUp();
        TEST_ASSERT_NOT_NULL(take_next());
        TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
        turn_on(0.3);
        motion.phase_step_q32 = i == 0 ? 1 : 0;
        motion.is_playing = i != 1;
        record.want.state = i == 2 ? cam_state_cutting : cam_state_rehearsing;
        motion.scale_step_q30 = i == 3 ? 1 : 0;
        turn_on(0.1);
        motion = (cam_motion_t){.is_playing = true};
        record.want.state = cam_state_rehearsing;
        bool was_seen = false;
        for (int k = 0; k < 3 && !was_seen; k++) {
            TEST_ASSERT_NOT_NULL(take_next());
            was_seen = i < 3 ? !turn.is_steady : turn.is_steady && !turn.is_level;
            TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
        }
        TEST_ASSERT_TRUE(was_seen);
    }
}

static void test_a_late_reader_is_reported_and_its_bank_stays(void)
{
    TEST_ASSERT_NOT_NULL(take_next());
    turn_on(0.9);
    TEST_ASSERT_FALSE(cam_turn_bins_release(&g));
    TEST_ASSERT_NOT_NULL(take_next()); // the bank is cleared for a later turn
    TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
}

static void test_a_turn_that_nobody_waited_for_is_not_offered(void)
{
    turn_on(10.2); // dirty: nothing has been cleared
    TEST_ASSERT_NULL(cam_turn_bins_take(&g, &turn));
    turn_on(1.0);
    TEST_ASSERT_NULL(cam_turn_bins_take(&g, &turn));
    turn_on(1.0);
    TEST_ASSERT_NOT_NULL(cam_turn_bins_take(&g, &turn));
    TEST_ASSERT_NULL(cam_turn_bins_take(&g, &turn)); // only once
}

static void test_turning_back_is_not_a_turn(void)
{
    TEST_ASSERT_NOT_NULL(take_next());
    TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
    const int64_t at_q32 = pos_q32;
    while (pos_q32 > at_q32 - 2 * CAM_TURN_Q32) {
        tick(-(int32_t)(CAM_TURN_Q32 / ticks_per_turn));
        TEST_ASSERT_NULL(cam_turn_bins_take(&g, &turn));
    }
}

/// As when the index becomes known.
static void test_after_a_jump_each_turn_is_gathered_alone(void)
{
    for (int i = 20; i < 30; i++) {
        setUp();
        TEST_ASSERT_NOT_NULL(take_next());
        TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
        turn_on(0.1);
        pos_q32 += i * CAM_TURN_Q32 / 10; // to another turn than the next
        for (int k = 0; k < 3; k++) {
            const cam_turn_bin_t *bins = take_next();
            TEST_ASSERT_NOT_NULL(bins);
            int32_t n = 0;
            for (uint32_t b = 0; b < cam_turn_bins_n; b++) {
                n += bins[b].n;
            }
            TEST_ASSERT_INT32_WITHIN(1, ticks_per_turn, n);
            TEST_ASSERT_TRUE(cam_turn_bins_release(&g));
        }
    }
}

/// The copy changes nothing; the configured gains stay what they are.
static void test_a_copy_keeps_the_configuration_and_its_ties(void)
{
    static cam_config_bank_t bank;
    memset(&bank, 0, sizeof bank);
    cam_config_t *first = cam_config_copy(&bank); // of nothing: a free half
    first->command.configured.k1_q16 = 1000;
    first->command.configured.k2_q16 = 50;
    first->generation = 3;
    cam_config_tie(first, true);
    const cam_learned_t learned = {.k1_q16 = -30, .k2_q16 = 7, .c = {1, 2}, .d = {3}, .dm = {4}};
    first->learned = learned;
    cam_config_learn(first);
    TEST_ASSERT_EQUAL_INT32(970, first->command.in_cut.k1_q16);
    TEST_ASSERT_EQUAL_INT32(57, first->command.in_cut.k2_q16);
    cam_config_offer(&bank);
    TEST_ASSERT_NULL(cam_config_copy(&bank)); // not taken yet
    (void)cam_config_take_isr(&bank);
    cam_config_t *copy = cam_config_copy(&bank);
    TEST_ASSERT_NOT_NULL(copy);
    TEST_ASSERT_TRUE(copy != first);
    TEST_ASSERT_EQUAL_INT32(1000, copy->command.configured.k1_q16);
    TEST_ASSERT_EQUAL_INT32(50, copy->command.configured.k2_q16);
    TEST_ASSERT_EQUAL_MEMORY(&learned, &copy->learned, sizeof learned);
    TEST_ASSERT_EQUAL_PTR(&copy->table, copy->play.table);
    TEST_ASSERT_EQUAL_PTR(copy->learned.c, copy->play.c);
    TEST_ASSERT_EQUAL_PTR(copy->learned.d, copy->play.d);
    TEST_ASSERT_EQUAL_PTR(copy->learned.dm, copy->spindle.dm);
    cam_config_tie(copy, false);
    TEST_ASSERT_NULL(copy->play.table);
}

/// @return ticks that count in a turn at a speed, checked bin by bin; 0: nothing was taken
static uint32_t counted_at(int32_t step_q32)
{
    const cam_turn_bin_t *bins = NULL;
    setUp();
    record.angle.speed_q32 = step_q32;
    const int64_t end_q32 = 4 * CAM_TURN_Q32;
    for (uint32_t i = 0; bins == NULL && pos_q32 < end_q32; i++) {
        tick(step_q32);
        bins = i % 500u == 0u ? cam_turn_bins_take(&g, &turn) : NULL;
    }
    uint32_t n = 0;
    for (uint32_t i = 0; bins != NULL && i < cam_turn_bins_n; i++) {
        n += (uint32_t)bins[i].n;
        TEST_ASSERT_LESS_OR_EQUAL_INT32(129, bins[i].n);
        TEST_ASSERT_EQUAL_INT32(bins[i].n * (64 * 10 + 5), bins[i].error_q6);
    }
    return n;
}

/// A turn of more than 2^14 ticks counts every 2nd, 4th .. 64th one, so 2^13 to 2^14 of them.
static void test_long_turns_leave_ticks_out(void)
{
    static const struct {
        int32_t speed_q32;
        uint32_t skip;
    } cases[] = {{1 << 20, 0},        {1 << 18, 0}, {(1 << 18) - 1, 1}, {1 << 17, 1},
                 {(1 << 17) - 64, 3}, {150000, 1},  {20000, 15},        {5000, 63}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const uint32_t n = counted_at(cases[i].speed_q32);
        const double due = 4294967296.0 / cases[i].speed_q32 / (cases[i].skip + 1u);
        TEST_ASSERT_EQUAL_UINT32(cases[i].skip, turn.skip);
        TEST_ASSERT_DOUBLE_WITHIN(plan_ticks, due, n); // the first plan of a turn sets it
    }
}
