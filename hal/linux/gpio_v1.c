// SPDX-License-Identifier: Apache-2.0
/// lin_gpio for libgpiod 1.6: one request per line.
#include "lin_gpio.h"
#include <errno.h>  // errno
#include <fcntl.h>  // O_NONBLOCK
#include <gpiod.h>  // gpiod_line_request
#include <stdlib.h> // calloc

struct lin_gpio {
    struct gpiod_chip *chip;
    struct gpiod_line *line;
    int edge_fd;
};

/// @return NULL with errno 0: the chip has no such line
static struct gpiod_line *find(struct gpiod_chip *chip, const lin_place_t *place)
{
    struct gpiod_line *line = NULL;
    if (place->name != NULL) {
        line = gpiod_chip_find_line(chip, place->name);
    } else if (place->offset < gpiod_chip_num_lines(chip)) {
        line = gpiod_chip_get_line(chip, place->offset);
    }
    errno = 0;
    return line;
}

static bool request(lin_gpio_t *g, lin_gpio_use_t use, bool is_active_low)
{
    const struct gpiod_line_request_config config = {
        .consumer = "camturn",
        .request_type = use == lin_gpio_output  ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT
                        : use == lin_gpio_edges ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES
                                                : GPIOD_LINE_REQUEST_DIRECTION_INPUT,
        .flags = is_active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0,
    };
    if (gpiod_line_request(g->line, &config, 0) != 0) {
        return false;
    }
    if (use == lin_gpio_edges) {
        g->edge_fd = gpiod_line_event_get_fd(g->line);
        return fcntl(g->edge_fd, F_SETFL, O_NONBLOCK) == 0;
    }
    return true;
}

lin_gpio_t *lin_gpio_new(void)
{
    return calloc(1, sizeof(lin_gpio_t));
}

bool lin_gpio_take(lin_gpio_t *g, const lin_place_t *where, lin_gpio_use_t use, bool is_active_low,
                   common_error_t *e)
{
    g->chip = gpiod_chip_open(where->chip);
    g->line = g->chip != NULL ? find(g->chip, where) : NULL;
    if (g->line == NULL || !request(g, use, is_active_low)) {
        const int err = errno;
        const char *who = g->line != NULL ? gpiod_line_consumer(g->line) : NULL;
        return lin_place_refuse(where, err, who != NULL ? who : "", e);
    }
    return true;
}

int lin_gpio_read(lin_gpio_t *g)
{
    return gpiod_line_get_value(g->line);
}

bool lin_gpio_write(lin_gpio_t *g, bool is_active)
{
    return gpiod_line_set_value(g->line, is_active ? 1 : 0) == 0;
}

int lin_gpio_edge(lin_gpio_t *g, int64_t *ns, bool *is_rising)
{
    struct gpiod_line_event event;
    if (gpiod_line_event_read_fd(g->edge_fd, &event) != 0) {
        return errno == EAGAIN ? 0 : -1;
    }
    *ns = (int64_t)event.ts.tv_sec * 1000000000 + event.ts.tv_nsec;
    *is_rising = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
    return 1;
}

void lin_gpio_close(lin_gpio_t *g)
{
    if (g->chip != NULL) {
        gpiod_chip_close(g->chip); // releases its lines
    }
    free(g);
}

const char *lin_gpio_library(void)
{
    return gpiod_version_string();
}
