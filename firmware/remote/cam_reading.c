// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include "cam_table.h" // cam_crc32
#include "camturn.h"   // CAMTURN_RECORDING_FRAME_ID
#include "hal/hal.h"   // hal_can_write
#include <string.h>    // memcpy

/// Bytes of a message after its number; most messages of one poll, which catches up after a full
/// bus.
enum { part_bytes = 7, fd_part_bytes = 63, most_per_poll = 8 };

static uint32_t part_of(const cam_reading_t *r)
{
    return r->is_fd ? (uint32_t)fd_part_bytes : (uint32_t)part_bytes;
}

cam_err_t cam_reading_begin(cam_reading_t *r, const cam_scope_t *scope, uint32_t offset,
                            uint32_t n_words, bool is_fd, uint32_t tick)
{
    const uint32_t n_there = cam_scope_n_recorded(scope);
    if (cam_scope_is_on(scope)) {
        return cam_err_scope_on;
    }
    if (offset >= n_there || n_words == 0u) {
        return cam_err_scope_range;
    }
    const uint32_t n = n_words < n_there - offset ? n_words : n_there - offset;
    *r = (cam_reading_t){
        .is_on = true,
        .is_fd = is_fd,
        .parameter = r->parameter,
        .number = scope->number,
        .from = offset * (uint32_t)sizeof(int32_t),
        .n_bytes = n * (uint32_t)sizeof(int32_t),
        .begin_tick = tick,
    };
    return cam_ok;
}

/// Copy bytes of the piece, which may wrap around the end of the recorder's ring.
static void copy(const cam_reading_t *r, const cam_scope_t *scope, uint32_t at, uint8_t *to,
                 uint32_t n)
{
    const cam_scope_span_t head = cam_scope_span(scope, r->from + at, n);
    (void)memcpy(to, head.bytes, head.n);
    if (head.n < n) {
        const cam_scope_span_t tail = cam_scope_span(scope, r->from + at + head.n, n - head.n);
        (void)memcpy(&to[head.n], tail.bytes, tail.n);
    }
}

/// Queue the next message. @return false without room
static bool send_part(cam_reading_t *r, const cam_scope_t *scope)
{
    const uint32_t at = r->n_sent * part_of(r);
    const uint32_t left = r->n_bytes - at;
    hal_can_frame_t frame = {
        .id = r->is_fd ? CAMTURN_RECORDING_FD_FRAME_ID : CAMTURN_RECORDING_FRAME_ID,
        .n = r->is_fd ? CAMTURN_RECORDING_FD_LENGTH : CAMTURN_RECORDING_LENGTH,
    };
    frame.data[0] = (uint8_t)r->n_sent;
    copy(r, scope, at, &frame.data[1], left < part_of(r) ? left : part_of(r));
    if (!hal_can_write(&frame)) {
        return false;
    }
    r->n_sent++;
    return true;
}

cam_reading_event_t cam_reading_poll(cam_reading_t *r, const cam_scope_t *scope, uint32_t tick)
{
    if (!r->is_on) {
        return cam_reading_nothing;
    }
    if (r->number != scope->number || r->from + r->n_bytes > cam_scope_n_recorded(scope) * 4u) {
        r->is_on = false;
        return cam_reading_lost;
    }
    const uint32_t n_parts = (r->n_bytes + part_of(r) - 1u) / part_of(r);
    const uint32_t rate_hz = r->is_fd ? (uint32_t)cam_reading_fd_hz : (uint32_t)cam_reading_hz;
    const uint64_t elapsed = (uint64_t)(tick - r->begin_tick) * rate_hz;
    const uint64_t due = elapsed / scope->tick_hz + 1u;
    bool has_room = true;
    for (int i = 0; i < most_per_poll && has_room && r->n_sent < n_parts && r->n_sent < due; i++) {
        has_room = send_part(r, scope);
    }
    r->is_on = r->n_sent < n_parts;
    return r->is_on ? cam_reading_nothing : cam_reading_complete;
}

uint32_t cam_reading_crc(const cam_reading_t *r, const cam_scope_t *scope)
{
    const cam_scope_span_t head = cam_scope_span(scope, r->from, r->n_bytes);
    const uint32_t crc = cam_crc32(0, head.bytes, head.n);
    if (head.n == r->n_bytes) {
        return crc;
    }
    const cam_scope_span_t tail = cam_scope_span(scope, r->from + head.n, r->n_bytes - head.n);
    return cam_crc32(crc, tail.bytes, tail.n);
}
