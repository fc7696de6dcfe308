// SPDX-License-Identifier: Apache-2.0
/// lin_gpio for libgpiod 2: one request per line.
#include "lin_gpio.h"
#include <errno.h>  // errno
#include <fcntl.h>  // O_NONBLOCK
#include <gpiod.h>  // gpiod_chip_request_lines
#include <stdio.h>  // snprintf
#include <stdlib.h> // calloc

struct lin_gpio {
    struct gpiod_line_request *request;
    struct gpiod_edge_event_buffer *event; ///< capacity 1
    unsigned offset;
};

enum { who_bytes = 64 };

static bool find(struct gpiod_chip *chip, const lin_place_t *place, unsigned *offset)
{
    *offset = place->offset;
    if (place->name == NULL) {
        return true; // checked by the request
    }
    const int found = gpiod_chip_get_line_offset_from_name(chip, place->name);
    if (found < 0) {
        errno = errno == ENOENT ? 0 : errno;
        return false;
    }
    *offset = (unsigned)found;
    return true;
}

static void find_user(struct gpiod_chip *chip, unsigned offset, char *who)
{
    struct gpiod_line_info *info = gpiod_chip_get_line_info(chip, offset);
    if (info != NULL) {
        const char *consumer = gpiod_line_info_get_consumer(info);
        (void)snprintf(who, who_bytes, "%s", consumer != NULL ? consumer : "");
        gpiod_line_info_free(info);
    }
}

static bool set(struct gpiod_line_settings *settings, lin_gpio_use_t use, bool is_active_low)
{
    gpiod_line_settings_set_active_low(settings, is_active_low);
    if (use == lin_gpio_output) {
        return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT) == 0 &&
               gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE) == 0;
    }
    return gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT) == 0 &&
           (use != lin_gpio_edges ||
            gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH) == 0);
}

static bool request(lin_gpio_t *g, struct gpiod_chip *chip, lin_gpio_use_t use, bool is_active_low)
{
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_line_config *lines = gpiod_line_config_new();
    struct gpiod_request_config *config = gpiod_request_config_new();
    if (settings != NULL && lines != NULL && config != NULL && set(settings, use, is_active_low) &&
        gpiod_line_config_add_line_settings(lines, &g->offset, 1, settings) == 0) {
        gpiod_request_config_set_consumer(config, "camturn");
        g->request = gpiod_chip_request_lines(chip, config, lines);
    }
    const int err = errno;
    gpiod_request_config_free(config);
    gpiod_line_config_free(lines);
    gpiod_line_settings_free(settings);
    errno = err;
    return g->request != NULL;
}

static bool want_edges(lin_gpio_t *g)
{
    g->event = gpiod_edge_event_buffer_new(1);
    return g->event != NULL &&
           fcntl(gpiod_line_request_get_fd(g->request), F_SETFL, O_NONBLOCK) == 0;
}

lin_gpio_t *lin_gpio_new(void)
{
    return calloc(1, sizeof(lin_gpio_t));
}

bool lin_gpio_take(lin_gpio_t *g, const lin_place_t *where, lin_gpio_use_t use, bool is_active_low,
                   common_error_t *e)
{
    struct gpiod_chip *from = gpiod_chip_open(where->chip);
    const bool is_found = from != NULL && find(from, where, &g->offset);
    const bool is_ours = is_found && request(g, from, use, is_active_low) &&
                         (use != lin_gpio_edges || want_edges(g));
    if (!is_ours) {
        const int err = errno;
        char who[who_bytes] = "";
        if (is_found) {
            find_user(from, g->offset, who);
        }
        // EINVAL: no such offset
        (void)lin_place_refuse(where, is_found && err == EINVAL ? 0 : err, who, e);
    }
    if (from != NULL) {
        gpiod_chip_close(from);
    }
    return is_ours;
}

int lin_gpio_read(lin_gpio_t *g)
{
    return (int)gpiod_line_request_get_value(g->request, g->offset);
}

bool lin_gpio_write(lin_gpio_t *g, bool is_active)
{
    const enum gpiod_line_value value =
        is_active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    return gpiod_line_request_set_value(g->request, g->offset, value) == 0;
}

int lin_gpio_edge(lin_gpio_t *g, int64_t *ns, bool *is_rising)
{
    const int n = gpiod_line_request_read_edge_events(g->request, g->event, 1);
    if (n <= 0) {
        return n == 0 || errno == EAGAIN ? 0 : -1;
    }
    struct gpiod_edge_event *event = gpiod_edge_event_buffer_get_event(g->event, 0);
    *ns = (int64_t)gpiod_edge_event_get_timestamp_ns(event);
    *is_rising = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE;
    return 1;
}

void lin_gpio_close(lin_gpio_t *g)
{
    gpiod_edge_event_buffer_free(g->event);
    if (g->request != NULL) {
        gpiod_line_request_release(g->request);
    }
    free(g);
}

const char *lin_gpio_library(void)
{
    return gpiod_api_version();
}
