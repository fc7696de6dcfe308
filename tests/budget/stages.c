// SPDX-License-Identifier: Apache-2.0
#include "stages.h"
#include "budget_count.h"

/// Inner marks of a tick, between stage_begin and stage_publish.
enum { n_inner = stage_n_marks - 2 };

static struct {
    uint32_t at[stage_n_marks]; ///< readings
    uint64_t order;             ///< the stages passed, a hexadecimal digit each
} marks;

static uint32_t per_mark;  ///< [instructions]
static uint32_t per_frame; ///< [instructions] of two outer readings and two marks, nothing between

/// Never inlined, without a branch: the same instructions at every mark.
__attribute__((noipa)) void stage_mark(stage_t stage)
{
    marks.at[stage] = budget_count();
    marks.order = marks.order << 4 | (uint64_t)stage;
}

const char *stages_name(stage_t stage)
{
    static const char *const names[stage_n_marks] = {
        [stage_begin] = "begin",     [stage_sense] = "sense", [stage_angle] = "angle",
        [stage_play] = "play",       [stage_guard] = "guard", [stage_command] = "command",
        [stage_actuate] = "actuate", [stage_plan] = "plan",   [stage_publish] = "publish",
    };
    return names[stage];
}

uint32_t stages_calibrate(void)
{
    budget_count_start();
    const uint32_t from = budget_count();
    stage_mark(stage_begin);
    stage_mark(stage_publish);
    per_frame = budget_instructions(from, budget_count());
    per_mark = budget_instructions(marks.at[stage_begin], marks.at[stage_publish]);
    return per_mark;
}

stages_t stages_count(void (*interrupt)(void))
{
    marks.order = 0;
    const uint32_t from = budget_count();
    stage_mark(stage_begin);
    interrupt();
    stage_mark(stage_publish);
    const uint32_t whole = budget_instructions(from, budget_count());
    stages_t n = {
        .whole = whole - per_frame - n_inner * per_mark,
        .is_in_order = marks.order == UINT64_C(0x12345678),
    };
    for (int stage = stage_sense; stage < stage_n_marks; stage++) {
        n.of[stage] = budget_instructions(marks.at[stage - 1], marks.at[stage]) - per_mark;
        n.sum += n.of[stage];
    }
    return n;
}
