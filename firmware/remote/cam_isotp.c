// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include <string.h> // memcpy

/// Kind of a frame: the high nibble of its first byte.
enum { single = 0, first = 1, consecutive = 2 };

/// Bytes of a frame; the longest length that has the short form; the shortest message that may be
/// sent in more than one frame.
enum { frame_bytes = 8, longest_short = 4095, shortest_first = 8 };

/// First byte of a flow control.
enum { flow_go_on = 0x30, flow_overflow = 0x32 };

/// Append received bytes to the message, up to its length.
static void append(cam_isotp_t *t, const uint8_t *bytes, uint32_t most)
{
    const uint32_t left = t->length - t->n;
    const uint32_t n = left < most ? left : most;
    (void)memcpy(&t->bytes[t->n], bytes, n);
    t->n += n;
}

static cam_isotp_event_t begin_single(cam_isotp_t *t, const hal_can_frame_t *frame)
{
    const uint32_t length = frame->data[0]; // its high nibble is 0
    if (length == 0u || length >= frame->n || length > t->capacity) {
        return cam_isotp_nothing;
    }
    t->is_receiving = false;
    t->has_flow = false;
    t->length = length;
    t->n = 0;
    append(t, &frame->data[1], length);
    return cam_isotp_message;
}

/// Request a flow control, which permits the sender's next block of frames.
static void ask_for_block(cam_isotp_t *t)
{
    t->n_block = cam_isotp_block_size;
    t->has_flow = true;
}

/// Take the first frame of a longer message. The length has 12 bits, or 32 bits if these are 0; the
/// first bytes of the message follow it.
static cam_isotp_event_t begin_long(cam_isotp_t *t, const hal_can_frame_t *frame, uint32_t tick)
{
    const uint8_t *d = frame->data;
    const uint32_t brief = (d[0] & 0xFu) * 256u + d[1];
    const uint32_t wide =
        (uint32_t)d[2] << 24 | (uint32_t)d[3] << 16 | (uint32_t)d[4] << 8 | (uint32_t)d[5];
    const uint32_t length = brief != 0u ? brief : wide;
    if (frame->n != frame_bytes || length < shortest_first ||
        (brief == 0u && length <= longest_short)) {
        return cam_isotp_nothing;
    }
    t->length = length;
    t->n = 0;
    t->next = 1;
    t->last_tick = tick;
    // A message beyond the capacity is refused by its flow control.
    t->is_too_long = length > t->capacity;
    t->is_receiving = !t->is_too_long;
    ask_for_block(t);
    if (t->is_receiving) {
        const uint32_t at = brief != 0u ? UINT32_C(2) : UINT32_C(6); // first byte after the length
        append(t, &d[at], frame_bytes - at);
    }
    return cam_isotp_nothing;
}

static cam_isotp_event_t take_consecutive(cam_isotp_t *t, const hal_can_frame_t *frame,
                                          uint32_t tick)
{
    const uint32_t left = t->length - t->n;
    const uint32_t due = left < frame_bytes - 1u ? left : frame_bytes - 1u;
    if (!t->is_receiving || frame->n <= due) {
        return cam_isotp_nothing;
    }
    if ((frame->data[0] & 0xFu) != t->next) {
        t->is_receiving = false;
        return cam_isotp_broken;
    }
    // append() drops the padding after the end of the message.
    append(t, &frame->data[1], frame_bytes - 1u);
    t->next = (t->next + 1u) % 16u;
    t->last_tick = tick;
    t->n_block--;
    if (t->n == t->length) {
        t->is_receiving = false;
        return cam_isotp_message;
    }
    if (t->n_block == 0u) {
        ask_for_block(t);
    }
    return cam_isotp_nothing;
}

cam_isotp_event_t cam_isotp_receive(cam_isotp_t *t, const hal_can_frame_t *frame, uint32_t tick)
{
    if (frame->n == 0u || frame->n > frame_bytes) {
        return cam_isotp_nothing;
    }
    switch (frame->data[0] >> 4) {
    case single:
        return begin_single(t, frame);
    case first:
        return begin_long(t, frame, tick);
    case consecutive:
        return take_consecutive(t, frame, tick);
    default:
        return cam_isotp_nothing; // flow control, reserved
    }
}

cam_isotp_event_t cam_isotp_wait(cam_isotp_t *t, uint32_t tick)
{
    if (!t->is_receiving || tick - t->last_tick <= t->timeout_ticks) {
        return cam_isotp_nothing;
    }
    t->is_receiving = false;
    t->has_flow = false;
    return cam_isotp_broken;
}

bool cam_isotp_flow(const cam_isotp_t *t, hal_can_frame_t *frame)
{
    frame->n = 3;
    frame->data[0] = t->is_too_long ? flow_overflow : flow_go_on;
    frame->data[1] = t->is_too_long ? 0u : cam_isotp_block_size;
    frame->data[2] = 0; // separation time: none
    return t->has_flow;
}
