// SPDX-License-Identifier: Apache-2.0
// The speeds and feeds that table and parameters allow.
#include "cam_machine.h"
#include "cam_pass.h" // cam_pass_check, cam_pass_feasibility

cam_err_t cam_machine_check_speed(const cam_machine_t *m, uint32_t speed_mrpm)
{
    uint32_t pass = 0;
    return m->has_table ? cam_pass_check(&m->table, &m->params, speed_mrpm, m->tick_hz, &pass)
                        : cam_err_no_table;
}

uint32_t cam_machine_highest_mrpm(const cam_machine_t *m)
{
    return m->has_table ? cam_pass_highest_mrpm(&m->table, &m->params, m->tick_hz) : 0u;
}

cam_feasibility_t cam_machine_feasibility(const cam_machine_t *m, uint32_t speed_mrpm)
{
    if (!m->has_table) {
        const uint32_t asked_mrpm = (uint32_t)m->params.spindle_mrpm;
        return (cam_feasibility_t){.err = cam_err_no_table,
                                   .speed_mrpm = speed_mrpm > 0u ? speed_mrpm : asked_mrpm};
    }
    uint32_t pass = 0;
    const cam_err_t err = cam_pass_check(&m->table, &m->params, speed_mrpm, m->tick_hz, &pass);
    return cam_pass_feasibility(&m->table, &m->params, speed_mrpm, m->tick_hz,
                                err == cam_ok ? m->pass : pass);
}
