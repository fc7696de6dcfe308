// SPDX-License-Identifier: Apache-2.0
#include "sim_bus.h"
#include "unity.h"
#include <string.h> // memcpy

enum { id_encoder = 0x181, id_other = 0x182 };

static sim_disturb_t disturb;
static char sent[64]; // letters of the encoder's frames in the order of sending
static uint32_t n_sent;

void setUp(void)
{
    disturb = (sim_disturb_t){0};
    memset(sent, 0, sizeof sent);
    n_sent = 0;
}

/// Run one period: the encoder sends a letter, another node sends, too.
static void say(char letter, double t_s)
{
    sim_frames_t queue = {.n = 0};
    sim_frame_put(sim_frames_add(&queue, id_encoder), (uint32_t)letter, 1);
    sim_frame_put(sim_frames_add(&queue, id_other), '-', 1);
    sim_disturb_pass(&disturb, &queue, id_encoder, t_s);
    uint32_t n_other = 0;
    for (uint32_t i = 0; i < queue.n; i++) {
        if (queue.frame[i].id == id_encoder) {
            sent[n_sent++] = (char)queue.frame[i].data[0];
        } else {
            n_other++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(1, n_other);
}

/// Missing frames are not sent, repeated ones are the last good one, swapped ones change in pairs.
static void test_frames_of_a_disturbance(void)
{
    static const struct {
        sim_disturb_kind_t kind;
        uint32_t n;
        const char *sent;
    } cases[] = {{sim_disturb_none, 0, "abcdefgh"},
                 {sim_disturb_missing, 2, "abefgh"},
                 {sim_disturb_repeated, 2, "abbbefgh"},
                 {sim_disturb_swapped, 2, "abdcfegh"}};
    for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        setUp();
        for (char c = 'a'; c <= 'h'; c++) {
            if (c == 'c') {
                sim_disturb_begin(&disturb, cases[i].kind, cases[i].n, 0.0);
            }
            say(c, (c - 'a') * 1e-3);
        }
        TEST_ASSERT_EQUAL_STRING(cases[i].sent, sent);
    }
}

static void test_late_frame_comes_at_its_time(void)
{
    sim_frame_t late;
    double at_s;
    say('a', 0.0);
    sim_disturb_begin(&disturb, sim_disturb_late, 1, 1.7e-3);
    say('b', 1e-3);
    TEST_ASSERT_FALSE(sim_disturb_due(&disturb, 2e-3, &late, &at_s));
    say('c', 2e-3);
    TEST_ASSERT_TRUE(sim_disturb_due(&disturb, 3e-3, &late, &at_s));
    TEST_ASSERT_EQUAL_DOUBLE(2.7e-3, at_s);
    TEST_ASSERT_EQUAL_UINT8('b', late.data[0]);
    TEST_ASSERT_FALSE(sim_disturb_due(&disturb, 4e-3, &late, &at_s));
    TEST_ASSERT_EQUAL_STRING("ac", sent);
}
