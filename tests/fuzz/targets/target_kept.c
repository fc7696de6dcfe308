// SPDX-License-Identifier: Apache-2.0
// What a port keeps over a restart is untrusted bytes: parameters as text, the head of a black box,
// values that were learned.
#include "cam_recorder.h"
#include "cam_param.h"
#include "cam_table.h" // cam_crc32
#include "fuzz_bytes.h"
#include "fuzz_digest.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include "fuzz_rig.h"
#include <stdio.h>
#include <string.h>

enum { box_words = 4096, signals_of_box = 9 };

static void expect_in_range(const cam_params_t *p)
{
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        const cam_param_info_t *info = cam_param_info((cam_param_id_t)i);
        const int32_t value = cam_param_get(p, (cam_param_id_t)i);
        FUZZ_EXPECT(value >= info->min && value <= info->max, "%s = %d", info->name, (int)value);
    }
}

static void read_params(const uint8_t *data, size_t size)
{
    static char text[cam_param_store_most_bytes];
    const cam_params_t before = cam_param_defaults();
    cam_params_t params = before;
    const hal_params_t kept = {.bytes = (const char *)data, .size = (uint32_t)size};
    const cam_param_store_found_t found = cam_param_store_read(&kept, &params);
    expect_in_range(&params);
    fuzz_note(found.err);
    fuzz_note(found.version);
    fuzz_note(found.n_unknown);
    fuzz_note(found.n_unfit);
    fuzz_note(found.n_missing);
    for (uint32_t i = 0; i < (uint32_t)cam_n_params; i++) {
        fuzz_note(cam_param_get(&params, (cam_param_id_t)i));
    }
    FUZZ_EXPECT(memchr(found.unknown, 0, sizeof found.unknown) != NULL, "no end of a name");
    if (found.err != cam_ok) {
        FUZZ_EXPECT(memcmp(&params, &before, sizeof params) == 0, "damaged, and taken");
        return;
    }
    const uint32_t n = cam_param_store_write(text, &params, found.version);
    FUZZ_EXPECT(n <= (uint32_t)cam_param_store_most_bytes, "%u bytes", (unsigned)n);
    cam_params_t again = before;
    const hal_params_t written = {.bytes = text, .size = n};
    const cam_param_store_found_t second = cam_param_store_read(&written, &again);
    FUZZ_EXPECT(second.err == cam_ok && second.version == found.version, "%d", (int)second.err);
    FUZZ_EXPECT(second.n_unknown + second.n_unfit + second.n_missing == 0u, "not all came back");
    FUZZ_EXPECT(memcmp(&params, &again, sizeof params) == 0, "others came back");
}

static void read_box(const uint8_t *data, size_t size)
{
    static int32_t words[box_words];
    const size_t n = size < sizeof words ? size : sizeof words;
    memcpy(words, data, n);
    cam_scope_t scope;
    cam_scope_init(&scope, (hal_memory_t){.words = words, .n_words = box_words}, 20000);
    fuzz_bytes_t b = {.at = data + size - (size > 4u ? 4u : size), .n = size > 4u ? 4u : 0u};
    const uint32_t n_kept = fuzz_u16(&b) % (box_words + 2u);
    if (!cam_blackbox_restore(&scope, n_kept)) {
        return;
    }
    FUZZ_EXPECT(scope.n_signals == (uint32_t)signals_of_box, "%u", (unsigned)scope.n_signals);
    FUZZ_EXPECT(scope.at + scope.ring.most_rows * scope.n_signals <= n_kept,
                "rows beyond the words");
    FUZZ_EXPECT(cam_blackbox_is_unread(&scope), "a box that nobody reads");
    const uint32_t n_bytes = cam_scope_n_recorded(&scope) * 4u;
    uint32_t sum = 0;
    for (uint32_t at = 0; at < n_bytes;) {
        const cam_scope_span_t span = cam_scope_span(&scope, at, n_bytes - at);
        FUZZ_EXPECT(span.n > 0u && span.n <= n_bytes - at, "%u bytes", (unsigned)span.n);
        for (uint32_t i = 0; i < span.n; i++) { // all of it may be read
            sum += span.bytes[i];
        }
        at += span.n;
    }
    fuzz_note(sum);
    FUZZ_EXPECT(sum <= n_bytes * 255u, "%u", (unsigned)sum);
}

static void read_learned(const uint8_t *data, size_t size)
{
    fuzz_rig_start((fuzz_start_t){.tick_hz = 20000, .part = 0, .state = cam_state_off});
    fuzz_bytes_t b = {.at = data, .n = size};
    while (b.n > 0u) {
        const uint32_t index = fuzz_u8(&b);
        const int32_t value = fuzz_i32(&b);
        const cam_err_t err = cam_machine_set_learned(&fuzz_rig.machine, index, value);
        if (err == cam_ok) {
            const int32_t is = cam_ilc_get(&fuzz_rig.machine.ilc, index);
            FUZZ_EXPECT(index < cam_ilc_n_values && is == value, "learned value %u is %d, not %d",
                        (unsigned)index, (int)is, (int)value);
        }
        cam_machine_ilc_poll(&fuzz_rig.machine, cam_state_off,
                             !cam_machine_status(&fuzz_rig.machine).is_u_at_rest);
        fuzz_rig_tick();
    }
    for (uint32_t i = 0; i < 16u; i++) {
        cam_machine_ilc_poll(&fuzz_rig.machine, cam_state_off,
                             !cam_machine_status(&fuzz_rig.machine).is_u_at_rest);
        fuzz_rig_tick();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 1u) {
        return -1;
    }
    if (data[0] == 'B') {
        read_box(data + 1, size - 1u);
    } else if (data[0] == 'L') {
        read_learned(data + 1, size - 1u);
    } else {
        read_params(data, size);
    }
    return 0;
}

/// The text is closed by its right CRC, as without it nothing is read.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    static const char last[] = "crc32 = ";
    enum { n_last = sizeof last - 1, most_digits = 12 };
    size = LLVMFuzzerMutate(data, size, max_size);
    if (size < 1u || data[0] == 'B' || data[0] == 'L' || seed % 16u == 0u) {
        return size;
    }
    size_t end = size;
    for (size_t i = 0; i + (size_t)n_last <= size; i++) {
        end = memcmp(data + i, last, n_last) == 0 ? i : end;
    }
    if (end + (size_t)n_last + (size_t)most_digits > max_size) {
        return size;
    }
    const uint32_t crc = cam_crc32(0, data, end);
    const int n =
        snprintf((char *)data + end, n_last + most_digits, "%s%lu\n", last, (unsigned long)crc);
    return end + (size_t)n;
}
