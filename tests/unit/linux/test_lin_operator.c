// SPDX-License-Identifier: Apache-2.0
// The Linux port's button and key as configured.
#include "lin_setup.h"
#include "unity.h"
#include <stdio.h> // snprintf

static lin_config_t config;
void setUp(void)
{
    config = lin_config_defaults();
}

static void test_by_default_nothing_is_allowed(void)
{
    const hal_operator_t people = lin_operator(&config);
    TEST_ASSERT_FALSE(people.has_acknowledge);
    TEST_ASSERT_FALSE(people.is_acknowledge_waived);
    TEST_ASSERT_FALSE(people.has_key);
}

static void test_lines_are_there_and_a_waiver_is_no_line(void)
{
    (void)snprintf(config.line[lin_line_key].place, lin_name_max, "KEY");
    (void)snprintf(config.line[lin_line_acknowledge].place, lin_name_max, "gpiochip0:3");
    TEST_ASSERT_TRUE(lin_operator(&config).has_key);
    TEST_ASSERT_TRUE(lin_operator(&config).has_acknowledge);
    TEST_ASSERT_FALSE(lin_operator(&config).is_acknowledge_waived);
    (void)snprintf(config.line[lin_line_acknowledge].place, lin_name_max, "waived");
    TEST_ASSERT_FALSE(lin_operator(&config).has_acknowledge);
    TEST_ASSERT_TRUE(lin_operator(&config).is_acknowledge_waived);
}
