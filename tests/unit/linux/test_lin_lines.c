// SPDX-License-Identifier: Apache-2.0
// The Linux port's lines on a chip that fails: what is repeated, what the inputs say then.
#include "hal/hal.h"
#include "lin_gpio.h"
#include "lin_port.h"
#include "unity.h"
#include <stdlib.h> // abort
#include <string.h> // strcmp

enum { n_places = 6 };

struct lin_gpio {
    const char *place;
    bool is_high, is_broken;
    uint32_t n_writes;
};

static lin_gpio_t chip[n_places] = {{.place = "ESTOP", .is_high = true},
                                    {.place = "READY", .is_high = true},
                                    {.place = "INDEX"},
                                    {.place = "ENABLE"},
                                    {.place = "FAULT"},
                                    {.place = "INCUT"}};
static lin_gpio_t *const estop = &chip[0], *const enable = &chip[3], *const fault = &chip[4];

lin_gpio_t *lin_gpio_open(const char *name, const char *place, lin_gpio_use_t use,
                          bool is_active_low, common_error_t *e)
{
    TEST_ASSERT_EQUAL_STRING("gpiochip0", name);
    TEST_ASSERT_FALSE(is_active_low);
    for (int i = 0; i < n_places; i++) {
        if (strcmp(place, chip[i].place) == 0) {
            TEST_ASSERT_TRUE((use == lin_gpio_output) == (i >= 3));
            return &chip[i];
        }
    }
    (void)common_error(e, "no such line");
    return NULL;
}

int lin_gpio_read(lin_gpio_t *line)
{
    return line->is_broken ? -1 : line->is_high ? 1 : 0;
}

bool lin_gpio_write(lin_gpio_t *line, bool is_active)
{
    line->n_writes++;
    line->is_high = line->is_broken ? line->is_high : is_active;
    return !line->is_broken;
}

int lin_gpio_edge(lin_gpio_t *line, int64_t *ns, bool *is_rising)
{
    (void)ns;
    (void)is_rising;
    return line->is_broken ? -1 : 0;
}

void lin_gpio_close(lin_gpio_t *line)
{
    (void)line;
}

const char *lin_gpio_library(void)
{
    return "none";
}

void setUp(void)
{
    const lin_config_t config = lin_config_defaults();
    common_error_t error;
    TEST_ASSERT_TRUE(lin_lines_open(&config, &error));
    for (int i = 0; i < n_places; i++) {
        chip[i].is_broken = false;
        chip[i].n_writes = 0;
    }
}

static void write(uint32_t outputs, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        lin_lines_write(outputs);
    }
}

static void expect_enable(bool is_high, uint32_t n_writes)
{
    TEST_ASSERT_EQUAL(is_high, enable->is_high);
    TEST_ASSERT_EQUAL_UINT32(n_writes, enable->n_writes);
}

/// Only changes are written, and enable low until it is written. A line that was lost is an
/// emergency stop for good.
static void test_enable_low_is_repeated_until_it_is_written(void)
{
    write(hal_out_enable, 10);
    expect_enable(true, 1);
    TEST_ASSERT_EQUAL_UINT32(0, fault->n_writes);
    TEST_ASSERT_EQUAL_HEX32(hal_in_drive_ready, lin_lines_read());
    TEST_ASSERT_EQUAL_INT(lin_n_lines, lin_lines_lost());
    enable->is_broken = true;
    write(hal_out_fault, 5);
    expect_enable(true, 6);
    TEST_ASSERT_EQUAL_INT(lin_line_enable, lin_lines_lost());
    TEST_ASSERT_EQUAL_HEX32(hal_in_estop, lin_lines_read());
    enable->is_broken = false;
    write(hal_out_fault, 2);
    expect_enable(false, 7);
    TEST_ASSERT_EQUAL_UINT32(1, fault->n_writes);
    // A write that failed may have taken effect, so low is written although it was low before.
    enable->is_broken = true;
    write(hal_out_enable | hal_out_fault, 1);
    enable->is_broken = false;
    enable->is_high = true;
    write(hal_out_fault, 1);
    expect_enable(false, 9);
    TEST_ASSERT_TRUE(estop->is_high);
    TEST_ASSERT_EQUAL_HEX32(hal_in_estop, lin_lines_read());
}

static void test_line_that_is_not_there_is_reported_by_its_key(void)
{
    lin_config_t config = lin_config_defaults();
    common_error_t error;
    (void)strcpy(config.line[lin_line_fault].place, "LAMP");
    TEST_ASSERT_FALSE(lin_lines_open(&config, &error));
    TEST_ASSERT_EQUAL_STRING("gpio.fault: no such line", error.text);
}
