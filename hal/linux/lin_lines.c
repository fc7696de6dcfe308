// SPDX-License-Identifier: Apache-2.0
#include "lin_port.h"
#include "hal/hal.h"   // hal_in_*, hal_out_*
#include "lin_gpio.h"  // lin_gpio_open
#include <stdatomic.h> // lost
#include <stddef.h>    // NULL

static lin_gpio_t *lines[lin_n_lines];
static _Atomic uint32_t lost = lin_n_lines; // first line lost; written by the tick, read by main()
static uint32_t written, unsure;            // hal_out_*; unsure: bits whose last write failed

static lin_gpio_use_t use_of(int line)
{
    if (line == lin_line_index) {
        return lin_gpio_edges;
    }
    return line < lin_line_enable ? lin_gpio_input : lin_gpio_output;
}

/// @return hal_out_* of a line, 0 for an input
static uint32_t out_bit(int line)
{
    switch (line) {
    case lin_line_enable:
        return hal_out_enable;
    case lin_line_fault:
        return hal_out_fault;
    case lin_line_in_cut:
        return hal_out_in_cut;
    default:
        return 0;
    }
}

bool lin_lines_open(const lin_config_t *config, common_error_t *e)
{
    for (int i = 0; i < lin_n_lines; i++) {
        const lin_line_config_t *c = &config->line[i];
        if (!lin_line_is_there(config, (lin_line_t)i)) {
            continue;
        }
        common_error_t why;
        lines[i] = lin_gpio_open(config->chip, c->place, use_of(i), c->is_active_low, &why);
        if (lines[i] == NULL) {
            return common_error(e, "%s: %s", lin_line_name((lin_line_t)i), why.text);
        }
    }
    return true;
}

static void lose(lin_line_t line)
{
    uint32_t none = lin_n_lines;
    (void)atomic_compare_exchange_strong(&lost, &none, (uint32_t)line);
}

static bool is_good(lin_line_t line)
{
    const int value = lines[line] != NULL ? lin_gpio_read(lines[line]) : 1;
    if (value < 0) {
        lose(line);
    }
    return value == 1;
}

_Static_assert((uint32_t)hal_in_key == (uint32_t)hal_in_home_u << 7 &&
                   lin_line_key == lin_line_home_u + 7,
               "button and key follow the homes in both lists");

/// @return hal_in_home_u and the seven bits above it; 0 for lines that are not wired
static uint32_t read_others(void)
{
    uint32_t bits = 0;
    for (int i = lin_line_home_u; i <= lin_line_key; i++) {
        const bool is_on = lines[i] != NULL && is_good((lin_line_t)i);
        bits |= is_on ? (uint32_t)hal_in_home_u << (i - lin_line_home_u) : 0u;
    }
    return bits;
}

uint32_t lin_lines_read(void)
{
    const bool is_closed = is_good(lin_line_estop);
    const bool is_ready = is_good(lin_line_ready);
    const uint32_t others = read_others();
    if (lin_lines_lost() != lin_n_lines) {
        return hal_in_estop;
    }
    return (is_closed ? 0u : (uint32_t)hal_in_estop) |
           (is_ready ? (uint32_t)hal_in_drive_ready : 0u) | others;
}

bool lin_lines_edge(int64_t *ns, bool *is_rising)
{
    if (lines[lin_line_index] == NULL) {
        return false;
    }
    const int got = lin_gpio_edge(lines[lin_line_index], ns, is_rising);
    if (got < 0) {
        lose(lin_line_index);
    }
    return got > 0;
}

/// @return hal_out_* of `which` that could not be written
static uint32_t write_lines(uint32_t bits, uint32_t which)
{
    uint32_t failed = 0;
    for (int i = lin_line_enable; i < lin_n_lines; i++) {
        const uint32_t bit = out_bit(i);
        const bool is_wanted = lines[i] != NULL && (which & bit) != 0u;
        if (is_wanted && !lin_gpio_write(lines[i], (bits & bit) != 0u)) {
            lose((lin_line_t)i);
            failed |= bit;
        }
    }
    return failed;
}

void lin_lines_write(uint32_t bits)
{
    unsure = write_lines(bits, (bits ^ written) | unsure);
    written = bits;
}

void lin_lines_safe(void)
{
    (void)write_lines(hal_out_fault, UINT32_MAX);
}

lin_line_t lin_lines_lost(void)
{
    return (lin_line_t)atomic_load(&lost);
}

const char *lin_lines_library(void)
{
    return lin_gpio_library();
}
