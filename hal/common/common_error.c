// SPDX-License-Identifier: Apache-2.0
#include "common_error.h"
#include <stdarg.h> // va_list
#include <stdio.h>  // vsnprintf

bool common_error(common_error_t *e, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    (void)vsnprintf(e->text, sizeof e->text, format, args);
    va_end(args);
    for (char *c = e->text; *c != '\0'; c++) {
        if ((unsigned char)*c < 0x20u || *c == 0x7f) { // e.g. from a quoted value
            *c = '?';
        }
    }
    return false;
}
