// SPDX-License-Identifier: Apache-2.0
#include "cam_state.h"

const char *cam_state_name(cam_state_t state)
{
    static const char *const names[cam_n_states] = {
        [cam_state_off] = "off",
        [cam_state_homing] = "homing",
        [cam_state_ready] = "ready",
        [cam_state_engaging] = "engaging",
        [cam_state_cutting] = "cutting",
        [cam_state_disengaging] = "disengaging",
        [cam_state_fault] = "fault",
        [cam_state_rehearsing] = "rehearsing",
        [cam_state_identifying] = "identifying",
        [cam_state_manual] = "manual",
        [cam_state_holding] = "holding",
    };
    return (unsigned)state < cam_n_states ? names[state] : "?";
}

const char *cam_fault_name(cam_fault_t fault)
{
#define FAULT_NAME(name, what) #name,
    static const char *const names[cam_n_faults] = {CAM_FAULTS(FAULT_NAME)};
    return (unsigned)fault < cam_n_faults ? names[fault] : "?";
}

const char *cam_fault_text(cam_fault_t fault)
{
#define FAULT_TEXT(name, what) what,
    static const char *const texts[cam_n_faults] = {CAM_FAULTS(FAULT_TEXT)};
    return (unsigned)fault < cam_n_faults ? texts[fault] : "?";
}
