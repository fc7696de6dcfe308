// SPDX-License-Identifier: Apache-2.0
#include "cam_teach.h"

const char *cam_teach_phase_name(cam_teach_phase_t phase)
{
    static const char *const names[cam_teach_n_phases] = {
        "off", "waiting", "settling", "drive", "probing", "shape", "cutting", "frozen"};
    return (unsigned)phase < cam_teach_n_phases ? names[phase] : "?";
}

const char *cam_teach_reason_name(cam_teach_reason_t reason)
{
    static const char *const names[cam_teach_n_reasons] = {"all",       "not_asked", "not_measured",
                                                           "no_table",  "modulated", "slow_turn",
                                                           "fast_turn", "lobes",     "diverged"};
    return (unsigned)reason < cam_teach_n_reasons ? names[reason] : "?";
}
