// SPDX-License-Identifier: Apache-2.0
/// lin_gpio: one line of a GPIO chip, in front of libgpiod 1 or 2. gpio_v1.c or gpio_v2.c is
/// compiled, whichever library is found at configure time; lin_gpio.c is common to both.
///
/// Levels are active or inactive: lines that are active low are inverted here.
#ifndef LIN_GPIO_H
#define LIN_GPIO_H

#include "common_error.h" // common_error_t
#include "lin_place.h"    // lin_place_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t

typedef enum {
    lin_gpio_input, ///< read by lin_gpio_read()
    lin_gpio_edges, ///< its edges are read by lin_gpio_edge()
    lin_gpio_output ///< written by lin_gpio_write(); inactive at first
} lin_gpio_use_t;

typedef struct lin_gpio lin_gpio_t;

/// Take a line for this program.
/// @param chip   in which a name is searched: gpiochip0 or a path
/// @param place  name of the line, or CHIP:OFFSET
/// @return       NULL and *e: no such chip or line, line in use (by whom), not permitted
/// Context: main(), before the tick.
lin_gpio_t *lin_gpio_open(const char *chip, const char *place, lin_gpio_use_t use,
                          bool is_active_low, common_error_t *e);

/// @return 1 active, 0 not, -1 the line is lost. Context: tick; one system call, does not wait.
int lin_gpio_read(lin_gpio_t *line);

/// @return false: the line is lost. Context: any; one system call, does not wait.
bool lin_gpio_write(lin_gpio_t *line, bool is_active);

/// Take the oldest edge.
/// @param ns         CLOCK_MONOTONIC, the kernel's stamp of the interrupt
/// @param is_rising  from inactive to active
/// @return           1 taken, 0 there is none, -1 the line is lost
/// Context: tick; one system call, does not wait.
int lin_gpio_edge(lin_gpio_t *line, int64_t *ns, bool *is_rising);

/// Give the line back.
void lin_gpio_close(lin_gpio_t *line);

/// @return version of the library, static
const char *lin_gpio_library(void);

// For lin_gpio_open() only

/// @return room for a line, nothing taken yet; NULL: no memory
lin_gpio_t *lin_gpio_new(void);

/// Take the line. @return false and *e as lin_gpio_open(); what was got is left to lin_gpio_close()
bool lin_gpio_take(lin_gpio_t *line, const lin_place_t *where, lin_gpio_use_t use,
                   bool is_active_low, common_error_t *e);

#endif
