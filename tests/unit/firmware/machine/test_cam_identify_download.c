// SPDX-License-Identifier: Apache-2.0
// The download of a wave into the memory of the recorder: its order, its sizes, its checksum; for
// how long it may be played, and that it goes with a release.
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
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes, 0));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, 400));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 0, bytes, 400)); // its answer was lost
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_block(m, 0, bytes + 4, 400));
    TEST_ASSERT_EQUAL_INT(cam_err_download_room, cam_machine_wave_block(m, 400, bytes, 404));
    TEST_ASSERT_EQUAL_INT(cam_err_download_room, cam_machine_wave_block(m, 4000, bytes, 4));
    TEST_ASSERT_EQUAL_INT(cam_err_download_short, cam_machine_wave_end(m, 0));
    TEST_ASSERT_EQUAL_UINT32(400, m->identify.received);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(m, 400, bytes + 400, 400));
    const uint32_t crc = cam_crc32(0, bytes, sizeof wave_nm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order, cam_machine_wave_end(m, crc));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_scope_start(m));
    TEST_ASSERT_EQUAL_INT(cam_err_scope_on, cam_machine_wave_begin(m, 64));
}

/// In ready, with a wave of 200 samples whose step from the last to the first no axis could follow.
static void load(void)
{
    bring(cam_state_ready);
    for (int32_t i = 0; i < 200; i++) {
        wave_nm[i] = 100 * (i - 100);
    }
    const uint8_t *bytes = (const uint8_t *)wave_nm;
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(&rig.machine, sizeof wave_nm));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_block(&rig.machine, 0, bytes, sizeof wave_nm));
    const uint32_t crc = cam_crc32(0, bytes, sizeof wave_nm);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_end(&rig.machine, crc));
}

/// A minute at 20 kHz, its fades included, has 1 200 000 ticks.
static void test_length_of_an_excitation_is_limited(void)
{
    static const struct {
        uint32_t n_periods, fade_ticks;
        bool is_good;
    } cases[] = {{1, 16, true},       {0, 16, false},      {1, 15, false},
                 {1, 65535, true},    {1, 65536, false},   {5990, 1000, true},
                 {5990, 1001, false}, {5991, 1000, false}, {UINT32_MAX, 16, false}};
    load();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const cam_verdict_t found =
            cam_machine_excite(&rig.machine, cases[i].n_periods, cases[i].fade_ticks);
        TEST_ASSERT_NOT_EQUAL_INT(cam_ok, found.err);
        TEST_ASSERT_EQUAL_INT(!cases[i].is_good, found.err == cam_err_wave_length);
        TEST_ASSERT_TRUE(cases[i].is_good || found.value == 1200000);
    }
}

static void test_a_release_forgets_the_wave(void)
{
    load();
    TEST_ASSERT_NOT_EQUAL_INT(cam_err_wave_none, cam_machine_excite(&rig.machine, 1, 16).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_wave_none, cam_machine_excite(&rig.machine, 1, 16).err);
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_wave_begin(&rig.machine, sizeof wave_nm));
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_release(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_download_order,
                          cam_machine_wave_block(&rig.machine, 0, (const uint8_t *)wave_nm, 4));
}

static void test_what_is_asked_for_comes_before_an_excitation(void)
{
    load();
    TEST_ASSERT_EQUAL_INT(cam_ok, cam_machine_disable(&rig.machine));
    TEST_ASSERT_EQUAL_INT(cam_err_busy, cam_machine_excite(&rig.machine, 1, 16).err);
    fixture_rig_ticks(&rig, 20);
    TEST_ASSERT_EQUAL_INT(cam_err_state, cam_machine_excite(&rig.machine, 1, 16).err);
}
