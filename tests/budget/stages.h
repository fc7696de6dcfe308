// SPDX-License-Identifier: Apache-2.0
/// stages: exact instructions of one interrupt, stage by stage.
///
/// What the marks cost is measured without an interrupt and taken off. What is left of them is how
/// they change the compiled tick: some instructions, so test_budget.c judges the tick without them.
#ifndef STAGES_H
#define STAGES_H

#include "stage_mark.h" // stage_t
#include <stdbool.h>    // bool
#include <stdint.h>     // uint32_t

/// Instructions of one tick.
typedef struct {
    uint32_t of[stage_n_marks]; ///< by stage; of[stage_begin] is 0
    uint32_t sum;               ///< of all stages
    uint32_t whole;             ///< by readings before the first mark and behind the last one
    bool is_in_order;           ///< every mark was passed once, in order
} stages_t;

/// @return sense .. publish
const char *stages_name(stage_t stage);

/// Start the counter and measure what a mark costs. To be called once, before stages_count().
/// @return instructions of one mark
uint32_t stages_calibrate(void);

/// Run the interrupt with its marks.
stages_t stages_count(void (*interrupt)(void));

#endif
