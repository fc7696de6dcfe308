// SPDX-License-Identifier: Apache-2.0
#include "sim_inject.h"

#define SEES_S 0.3
#define PRESSES_S 0.2

void sim_operator_press(sim_operator_t *o, double time_s, double press_s)
{
    o->until_s = time_s + press_s;
}

bool sim_operator_step(sim_operator_t *o, bool is_needed, double time_s)
{
    const double passed_s = time_s - o->since_s;
    const bool is_pressing = o->is_waiting && passed_s >= SEES_S && passed_s < SEES_S + PRESSES_S;
    if (!o->is_waiting || passed_s >= SEES_S + PRESSES_S || (!is_needed && !is_pressing)) {
        o->is_waiting = o->is_present && is_needed;
        o->since_s = time_s;
    }
    return is_pressing || time_s < o->until_s;
}

bool sim_operator_key(sim_operator_t *o, uint32_t session)
{
    const bool is_new = o->turns_key && session != 0u && session != o->session;
    o->session = session;
    return o->is_key_on && !is_new;
}
