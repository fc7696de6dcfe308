// SPDX-License-Identifier: Apache-2.0
#include "cam_param.h"

const char *cam_text_number(char *buffer, int64_t value)
{
    static const char digits[] = "0123456789";
    uint32_t at = (uint32_t)cam_text_number_bytes - 1u;
    uint64_t left = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    buffer[at] = '\0';
    do {
        at--;
        buffer[at] = digits[left % 10u];
        left /= 10u;
    } while (left > 0u);
    if (value < 0) {
        at--;
        buffer[at] = '-';
    }
    return &buffer[at];
}
