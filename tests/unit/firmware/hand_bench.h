// SPDX-License-Identifier: Apache-2.0
/// hand_bench: the controller of rig_bench.h in the state manual, and how far its axes move.
#ifndef HAND_BENCH_H
#define HAND_BENCH_H

#include "cam_machine_hand.h" // cam_machine_manual
#include "rig_bench.h"        // rig
#include <stdlib.h>           // labs

enum { tick_hz = 20000, patience_ticks = tick_hz / 4, mm = 1000000 };

static inline cam_machine_t *machine(void)
{
    return &rig.machine;
}

static inline void set(cam_param_id_t id, int32_t value)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, fixture_rig_set(&rig, id, value));
}

static inline void to_manual(void)
{
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_manual(&rig.machine));
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_state_manual, fixture_rig_state());
}

static inline cam_hand_t hand(void)
{
    return fixture_rig_status(&rig).hand;
}

static inline int32_t port_nm(hal_axis_t axis)
{
    return hal_host.out.axis[axis].pos_nm;
}

/// Let the axis come to rest while its commander lives. @return what came of the order
static inline cam_hand_end_t until_rest(void)
{
    enum { patience = 400000 };
    fixture_rig_ticks(&rig, 20);
    // The main loop is slower than the ticks.
    for (uint32_t i = 0; i < patience && hand().phase != cam_hand_rest; i += 8u) {
        if (i % 1000u == 0u) {
            cam_machine_hand_alive(&rig.machine);
        }
        cam_machine_hand_poll(&rig.machine);
        fixture_rig_ticks(&rig, 8);
    }
    fixture_rig_ticks(&rig, 2000);
    cam_machine_hand_poll(&rig.machine);
    fixture_rig_ticks(&rig, 20);
    return hand().end;
}

/// Largest step of an axis per tick, and largest change of it, up to now.
typedef struct {
    int32_t last_nm, step_nm;
    int32_t most_step_nm, most_change_nm;
} motion_t;

static inline motion_t motion_of(hal_axis_t axis)
{
    return (motion_t){.last_nm = port_nm(axis)};
}

static inline void watch(motion_t *w, hal_axis_t axis)
{
    const int32_t step_nm = port_nm(axis) - w->last_nm;
    const int32_t change_nm = (int32_t)labs((long)step_nm - w->step_nm);
    w->most_step_nm = labs(step_nm) > w->most_step_nm ? (int32_t)labs(step_nm) : w->most_step_nm;
    w->most_change_nm = change_nm > w->most_change_nm ? change_nm : w->most_change_nm;
    w->last_nm += step_nm;
    w->step_nm = step_nm;
}

#endif
