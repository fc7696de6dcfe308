// SPDX-License-Identifier: Apache-2.0
#include "common_number.h"
#include <math.h>   // isfinite
#include <stdlib.h> // strtod
#include <string.h> // strspn

bool common_number_parse(const char *text, double *value)
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
