// SPDX-License-Identifier: Apache-2.0
#include "cam_err.h"
#include <stddef.h> // NULL

const char *cam_err_text(cam_err_t err)
{
#define ERR_TEXT(name, number, text) [-(number)] = (text),
    static const char *const texts[] = {[0] = "done", CAM_ERRORS(ERR_TEXT)};
    const unsigned i = 0u - (unsigned)err;
    const char *text = i < sizeof texts / sizeof texts[0] ? texts[i] : NULL;
    return text != NULL ? text : "unknown error";
}
