// SPDX-License-Identifier: Apache-2.0
// The download of a wave into the memory of the recorder: its order, its sizes, its checksum.
#include "cam_machine_identify.h"
#include "cam_machine_scope.h"
#include "cam_table.h"
#include "rig_bench.h"

static int32_t wave_nm[200];

static void test_downloads_out_of_order_are_refused(void)
{
    cam_machine_t *m = &rig.machine;
    for (int32_t i = 0; i < 200; i++) {
        wave_nm[i] = 100 * (i - 100);
    }
    const uint8_t *bytes = (const uint8_t *)wave_nm;
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes, 4));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_length, cam_machine_wave_begin(m, 60));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_length, cam_machine_wave_begin(m, 66));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_memory, cam_machine_wave_begin(m, UINT32_MAX - 3u));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(m, sizeof wave_nm));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 4, bytes, 4));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes, 3));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, 400));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, 400)); // its answer was lost
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes + 4, 400));
    TEST_ASSERT_EQUAL_INT(cam_err_download_room, cam_machine_wave_block(m, 400, bytes, 404));
    TEST_ASSERT_EQUAL_INT(cam_err_download_room, cam_machine_wave_block(m, 4000, bytes, 4));
    TEST_ASSERT_EQUAL_INT(cam_err_download_short, cam_machine_wave_end(m, 0));
    TEST_ASSERT_EQUAL_UINT32(400, cam_machine_wave_received(m));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 400, bytes + 400, 400));
    const uint32_t crc = cam_crc32(0, bytes, sizeof wave_nm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_on, cam_machine_wave_begin(m, 64));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_downloads_out_of_order_are_refused);
    return UNITY_END();
}
