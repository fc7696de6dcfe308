// SPDX-License-Identifier: Apache-2.0
// Messages of more than one frame, beside a second reader of ISO 15765-2 that was written from the
// standard's tables: both complete the same messages.
#include "cam_remote_inner.h" // cam_isotp_t, cam_isotp_broken, cam_isotp_event_t
#include "fuzz_bytes.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include <string.h>

enum { capacity = 64, frame_bytes = 10, timeout_ticks = 100, guard_byte = 0xA5 };

/// The second reader, in one function.
typedef struct {
    uint8_t bytes[capacity];
    uint32_t length, n, next, heard_at;
    bool is_on;
} twin_t;

static bool twin_take(twin_t *t, const hal_can_frame_t *f, uint32_t now)
{
    const uint32_t kind = f->data[0] / 16u;
    const uint32_t low = f->data[0] % 16u;
    if (f->n < 1u || f->n > 8u) {
        return false;
    }
    if (kind == 0u && low >= 1u && low < f->n && low <= (uint32_t)capacity) {
        t->is_on = false;
        t->length = low;
        memcpy(t->bytes, f->data + 1, low);
        return true;
    }
    if (kind == 1u && f->n == 8u) {
        const uint32_t twelve = low * 256u + f->data[1];
        const uint32_t all =
            ((f->data[2] * 256u + f->data[3]) * 256u + f->data[4]) * 256u + f->data[5];
        if ((twelve > 0u && twelve < 8u) || (twelve == 0u && all < 4096u)) {
            return false;
        }
        t->length = twelve > 0u ? twelve : all;
        t->is_on = t->length <= (uint32_t)capacity;
        t->n = twelve > 0u ? 6u : 2u;
        t->next = 1;
        t->heard_at = now;
        memcpy(t->bytes, f->data + 8u - t->n, t->n);
        return false;
    }
    if (kind == 2u && t->is_on) {
        const uint32_t left = t->length - t->n;
        const uint32_t take = left < 7u ? left : 7u;
        if (f->n <= take) {
            return false;
        }
        t->is_on = low == t->next;
        if (t->is_on) {
            memcpy(t->bytes + t->n, f->data + 1, take);
            t->n += take;
            t->next = (t->next + 1u) % 16u;
            t->heard_at = now;
            t->is_on = t->n < t->length;
            return !t->is_on;
        }
    }
    return false;
}

static hal_can_frame_t frame_of(fuzz_bytes_t *b)
{
    hal_can_frame_t f = {.id = 0x6C0, .n = fuzz_u8(b) % 10u};
    for (uint32_t i = 0; i < 8u; i++) {
        f.data[i] = fuzz_u8(b);
    }
    return f;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t bytes[capacity + 1];
    bytes[capacity] = guard_byte;
    cam_isotp_t t = {.bytes = bytes, .capacity = capacity, .timeout_ticks = timeout_ticks};
    twin_t twin;
    memset(&twin, 0, sizeof twin);
    fuzz_bytes_t b = {.at = data, .n = size};
    uint32_t now = 0xFFFFFF00u; // the clock wraps meanwhile
    uint32_t n_due = 0;
    while (b.n > 0u) {
        now += fuzz_u8(&b) % 128u;
        if (cam_isotp_wait(&t, now) == cam_isotp_broken) {
            FUZZ_EXPECT(twin.is_on && now - twin.heard_at > (uint32_t)timeout_ticks, "too early");
        }
        twin.is_on = twin.is_on && now - twin.heard_at <= (uint32_t)timeout_ticks;
        const hal_can_frame_t frame = frame_of(&b);
        const bool was_on = twin.is_on;
        const bool is_due = twin_take(&twin, &frame, now);
        const cam_isotp_event_t event = cam_isotp_receive(&t, &frame, now);
        FUZZ_EXPECT((event == cam_isotp_message) == is_due, "event %d", (int)event);
        FUZZ_EXPECT(event != cam_isotp_broken || was_on, "nothing can break");
        FUZZ_EXPECT(t.is_receiving == twin.is_on, "receiving: %d", (int)t.is_receiving);
        FUZZ_EXPECT(bytes[capacity] == guard_byte, "beyond the place");
        if (is_due) {
            FUZZ_EXPECT(t.length == twin.length, "%u bytes of %u", (unsigned)t.length,
                        (unsigned)twin.length);
            FUZZ_EXPECT(memcmp(bytes, twin.bytes, t.length) == 0, "another message");
        }
        hal_can_frame_t flow = {0};
        n_due = cam_isotp_flow(&t, &flow) ? n_due + 1u : 0u;
        FUZZ_EXPECT(flow.n == 3u && (flow.data[0] == 0x30 || flow.data[0] == 0x32), "flow");
        if (n_due > frame.data[7] % 4u) { // sometimes it is sent late
            t.has_flow = false;
        }
    }
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_mutate_orders(data, size, max_size, seed, frame_bytes, frame_bytes);
}
