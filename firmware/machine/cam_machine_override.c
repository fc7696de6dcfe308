// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_override.h"
#include "cam_machine_inner.h" // cam_machine_hand_over

/// Hold or resume the feed. cam_machine_poll() retries while the interrupt has not taken the last
/// configuration.
static void ask(cam_machine_t *m, bool is_held)
{
    m->is_held = is_held;
    m->is_rate_due = true;
    m->is_rate_due = cam_machine_hand_over(m, &m->params, &m->table, m->pass) != cam_ok;
}

cam_err_t cam_machine_hold(cam_machine_t *m)
{
    const cam_state_t state = cam_machine_status(m).state;
    if (m->params.z_is_measured != 0) {
        return cam_err_override_measured;
    }
    if (!m->has_table || !cam_state_is_in_work(state) || state == cam_state_disengaging) {
        return cam_err_state;
    }
    if (!m->is_held) {
        ask(m, true);
    }
    return cam_ok;
}

cam_err_t cam_machine_resume(cam_machine_t *m)
{
    if (!m->is_held) {
        return cam_err_state;
    }
    ask(m, false);
    return cam_ok;
}

cam_err_t cam_machine_set_parts(cam_machine_t *m, int32_t n)
{
    if (n < 0) {
        return cam_err_param_range;
    }
    m->n_parts = (uint32_t)n;
    return cam_ok;
}

void cam_machine_override_poll(cam_machine_t *m, const cam_status_t *status)
{
    const bool is_over =
        m->is_held && !cam_machine_is_pending(m, status) && !cam_state_is_in_work(status->state);
    if (is_over || (m->is_rate_due && m->has_table)) {
        ask(m, m->is_held && !is_over);
    }
}
