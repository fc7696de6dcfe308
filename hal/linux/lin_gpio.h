// SPDX-License-Identifier: Apache-2.0
/// lin_gpio: a GPIO line, by libgpiod 1 (gpio_v1.c) or 2 (gpio_v2.c), chosen at configure time.
///
/// Levels are active or inactive; active-low lines are inverted here.
#ifndef LIN_GPIO_H
#define LIN_GPIO_H

#include "common_error.h" // common_error_t
#include "lin_setup.h"    // lin_place_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t

typedef enum {
    lin_gpio_input, ///< for lin_gpio_read()
    lin_gpio_edges, ///< for lin_gpio_edge()
    lin_gpio_output ///< for lin_gpio_write(); initially inactive
} lin_gpio_use_t;

typedef struct lin_gpio lin_gpio_t;

/// Request a line.
/// @param chip   chip for lines given by name: gpiochip0 or a path
/// @param place  name of the line, or CHIP:OFFSET
/// @return       NULL and *e: no such chip or line, line in use (and by which program), no
/// permission Context: main(), before the tick.
lin_gpio_t *lin_gpio_open(const char *chip, const char *place, lin_gpio_use_t use,
                          bool is_active_low, common_error_t *e);

/// @return 1 active, 0 inactive, -1 line lost. Context: tick; one system call, does not block.
int lin_gpio_read(lin_gpio_t *line);

/// @return false if the line is lost. Context: any; one system call, does not block.
bool lin_gpio_write(lin_gpio_t *line, bool is_active);

/// Read the oldest edge.
/// @param ns         result: CLOCK_MONOTONIC, the kernel's time stamp of the interrupt
/// @param is_rising  result: from inactive to active
/// @return           1 edge read, 0 no edge, -1 line lost
/// Context: tick; one system call, does not block.
int lin_gpio_edge(lin_gpio_t *line, int64_t *ns, bool *is_rising);

/// Release the line.
void lin_gpio_close(lin_gpio_t *line);

/// @return version of the library, static
const char *lin_gpio_library(void);

// For lin_gpio_open() only

/// @return memory for a line, not yet requested; NULL: out of memory
lin_gpio_t *lin_gpio_new(void);

/// Request the line. @return false and *e as lin_gpio_open(); then call lin_gpio_close()
bool lin_gpio_take(lin_gpio_t *line, const lin_place_t *where, lin_gpio_use_t use,
                   bool is_active_low, common_error_t *e);

#endif
