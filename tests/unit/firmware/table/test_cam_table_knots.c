// SPDX-License-Identifier: Apache-2.0
// Single knots: what the arithmetic cannot hold is refused as that, what it holds but the entry
// does not promise as that.
#include "cam_table.h"
#include "fixture_image.h"
#include "unity.h"

static fixture_image_t image;
static cam_table_t table;

void setUp(void)
{
    const fixture_part_t part = fixture_part_short();
    fixture_image_make(&image, &part);
}

/// @return what becomes of a table with one word of a knot changed: 0 value, 1 and 2 derivatives
static cam_err_t with(uint32_t channel, uint32_t knot, uint32_t field, int32_t value)
{
    setUp();
    cam_knot_t *k = &fixture_image_knots(&image, channel)[knot];
    *(field == 0u ? &k->p : field == 1u ? &k->v : &k->a) = value;
    fixture_image_seal(&image);
    return cam_table_check(image.bytes, image.size, &table);
}

static void test_knot_beyond_the_arithmetic_is_refused_before_it_is_compared(void)
{
    static const uint32_t channels[] = {fixture_u, fixture_x};
    for (uint32_t i = 0; i < 12u; i++) {
        const int32_t sign = i % 2u == 0u ? 1 : -1;
        const uint32_t channel = channels[i / 6u];
        const uint32_t field = i / 2u % 3u;
        TEST_ASSERT_EQUAL_INT(cam_err_image_knots, with(channel, 0, field, sign * (1 << 25)));
        TEST_ASSERT_EQUAL_INT(cam_err_image_limits,
                              with(channel, 0, field, sign * ((1 << 25) - 1)));
    }
}
