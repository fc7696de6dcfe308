// SPDX-License-Identifier: Apache-2.0
#include "sim_error.h"
#include <math.h>   // isfinite
#include <stdarg.h> // va_list
#include <stdio.h>  // vsnprintf
#include <stdlib.h> // strtod
#include <string.h> // strspn

bool sim_error(sim_error_t *e, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    (void)vsnprintf(e->text, sizeof e->text, format, args);
    va_end(args);
    for (char *c = e->text; *c != '\0'; c++) {
        if ((unsigned char)*c < 0x20u || *c == 0x7f) { // a value may hold anything
            *c = '?';
        }
    }
    return false;
}

bool sim_parse_number(const char *text, double *value)
{
    if (text[0] == '\0' || strspn(text, "+-.0123456789eE") != strlen(text)) {
        return false;
    }
    char *end = NULL;
    const double number = strtod(text, &end);
    if (*end != '\0' || end == text || !isfinite(number)) {
        return false;
    }
    *value = number;
    return true;
}
