// SPDX-License-Identifier: Apache-2.0
// Damage that a CRC does not show: what the check accepts all the same is harmless.
#include "fixture_image.h"
#include "fixture_random.h"
#include "fixture_reference.h"
#include "cam_eval.h"
#include "unity.h"
#include <math.h>

static long double off(int32_t got, long double wanted)
{
    return fabsl((long double)got - wanted);
}

/// Every image that the check accepts must evaluate without overflow; compared with exact
/// arithmetic.
static void expect_sound_evaluation(const cam_table_t *t, fixture_random_t *random)
{
    for (int i = 0; i < 4; i++) {
        const uint32_t theta_q32 = fixture_random_u32(random);
        const int32_t z_nm = (int32_t)fixture_random_u32(random);
        const cam_value_t got = cam_eval_surface_at(&t->u, theta_q32, cam_eval_height(&t->u, z_nm));
        const fixture_value_t exact = fixture_reference_surface_at(&t->u, theta_q32, z_nm);
        const long double slack = 2e-4L * CAM_TABLE_SUM_MAX * t->u.span_nm / 2e9L;
        TEST_ASSERT_TRUE(off(got.y, exact.y) <= 1.0L + slack);
        (void)cam_eval_profile(&t->x, z_nm);
    }
}

enum { n_damages = 20000 / fixture_rarer };

static void test_check_random_damage_with_a_right_crc_is_refused_or_harmless(void)
{
    static fixture_image_t image;
    const fixture_part_t part = fixture_part_short();
    cam_table_t table;
    fixture_random_t random = {.state = 7};
    uint32_t n_accepted = 0;
    for (int i = 0; i < n_damages; i++) {
        if (i % 8 == 0) {
            fixture_image_make(&image, &part);
        }
        const size_t at = (size_t)fixture_random_range(&random, 24, (int64_t)image.size - 1);
        image.bytes[at] = (uint8_t)fixture_random_u32(&random);
        fixture_image_seal(&image);
        if (cam_table_check(image.bytes, image.size, &table) == cam_ok) {
            n_accepted++;
            expect_sound_evaluation(&table, &random);
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(n_damages / 200, n_accepted);
}
