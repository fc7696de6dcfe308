// SPDX-License-Identifier: Apache-2.0
#include "cam_err.h"

const char *cam_err_text(cam_err_t err)
{
    switch (err) {
    case cam_ok:
        return "done";
#define ERR_TEXT(name, number, clause)                                                             \
    case cam_err_##name:                                                                           \
        return (clause);
        CAM_ERRORS(ERR_TEXT)
#undef ERR_TEXT
    default:
        return "unknown error";
    }
}
