// SPDX-License-Identifier: Apache-2.0
#include "lin_gpio.h"
#include "lin_setup.h" // lin_place_parse
#include <stddef.h>    // NULL

lin_gpio_t *lin_gpio_open(const char *chip, const char *place, lin_gpio_use_t use,
                          bool is_active_low, common_error_t *e)
{
    lin_place_t where;
    if (!lin_place_parse(&where, chip, place, e)) {
        return NULL;
    }
    lin_gpio_t *line = lin_gpio_new();
    if (line == NULL) {
        (void)common_error(e, "out of memory for a line");
    } else if (!lin_gpio_take(line, &where, use, is_active_low, e)) {
        lin_gpio_close(line);
        line = NULL;
    }
    return line;
}
