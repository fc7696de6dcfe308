// SPDX-License-Identifier: Apache-2.0
// What was learned, as others see and set it.
#include "cam_machine.h"

cam_teach_status_t cam_machine_learning(const cam_machine_t *m)
{
    (void)m;
    return (cam_teach_status_t){.reason = cam_teach_not_asked};
}

cam_teach_harmonic_t cam_machine_harmonic(const cam_machine_t *m, uint32_t k)
{
    (void)m;
    (void)k;
    return (cam_teach_harmonic_t){0};
}

cam_err_t cam_machine_get_learned(const cam_machine_t *m, uint32_t index, int32_t *value)
{
    (void)m;
    *value = 0;
    return index < cam_teach_n_values ? cam_ok : cam_err_param_id;
}

cam_err_t cam_machine_set_learned(cam_machine_t *m, uint32_t index, int32_t value)
{
    (void)m;
    (void)value;
    return index < cam_teach_n_values ? cam_err_param_state : cam_err_param_id;
}
