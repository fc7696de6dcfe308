// SPDX-License-Identifier: Apache-2.0
#include "cam_err.h"

const char *cam_err_text(cam_err_t err)
{
    const char *text = "unknown error";
    switch (err) {
    case cam_ok:
        text = "done";
        break;
#define ERR_TEXT(name, number, clause)                                                             \
    case cam_err_##name:                                                                           \
        text = (clause);                                                                           \
        break;
        CAM_ERRORS(ERR_TEXT)
#undef ERR_TEXT
    default:
        break;
    }
    return text;
}
