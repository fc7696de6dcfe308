// SPDX-License-Identifier: Apache-2.0
#include "fixture_can.h"
#include "hal_host.h" // hal_host
#include <string.h>   // memset

void fixture_can_init(fixture_can_t *f, const fixture_part_t *part, uint32_t tick_hz)
{
    fixture_rig_init(&f->rig, part, tick_hz);
    fixture_image_t *image = &f->rig.image;
    memset(image->bytes + image->size, 0xFF, sizeof image->bytes - image->size);
    hal_host.slow.table = (hal_image_t){.bytes = image->bytes, .size = sizeof image->bytes};
}

void fixture_can_start(fixture_can_t *f)
{
    cam_machine_init(&f->rig.machine, &g_cam, hal_tick_hz(), hal_clock_hz());
    cam_can_init(&f->can, &f->rig.machine);
    fixture_rig_tick(&f->rig);
}

void fixture_can_loop(fixture_can_t *f, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) {
        cam_machine_poll(&f->rig.machine);
        cam_can_poll(&f->can);
        fixture_rig_tick(&f->rig);
    }
}

void fixture_can_receive(uint32_t id, uint32_t n, uint8_t command, uint8_t index, int32_t value)
{
    hal_can_frame_t frame = {.id = id, .n = n, .data = {command, index}};
    for (uint32_t i = 0; i < 4u; i++) {
        frame.data[4 + i] = (uint8_t)((uint32_t)value >> (8u * i));
    }
    (void)hal_host_can_receive(&frame);
}

static uint32_t n_kept(void)
{
    return hal_host.slow.n_sent < hal_host_can_frames ? hal_host.slow.n_sent : hal_host_can_frames;
}

/// @param page  byte 0, or -1: any
static hal_can_frame_t newest(uint32_t id, int page)
{
    for (uint32_t i = 1; i <= n_kept(); i++) {
        const hal_can_frame_t *frame =
            &hal_host.slow.sent[(hal_host.slow.n_sent - i) % hal_host_can_frames];
        if (frame->id == id && (page < 0 || frame->data[0] == page)) {
            return *frame;
        }
    }
    return (hal_can_frame_t){0};
}

hal_can_frame_t fixture_can_sent(uint32_t id)
{
    return newest(id, -1);
}

hal_can_frame_t fixture_can_detail(uint8_t page)
{
    return newest(0x4C0, page);
}

fixture_answer_t fixture_can_command(fixture_can_t *f, uint8_t command, uint8_t index,
                                     int32_t value)
{
    const uint32_t n_sent = hal_host.slow.n_sent;
    fixture_can_receive(0x640, 8, command, index, value);
    cam_can_poll(&f->can);
    fixture_rig_tick(&f->rig);
    const hal_can_frame_t *first = &hal_host.slow.sent[n_sent % hal_host_can_frames];
    const bool is_answered = hal_host.slow.n_sent != n_sent && first->id == 0x5C0u;
    return is_answered ? fixture_can_answer(first) : (fixture_answer_t){.command = UINT32_MAX};
}

fixture_answer_t fixture_can_answer(const hal_can_frame_t *frame)
{
    return (fixture_answer_t){
        .command = frame->n == 8u ? frame->data[0] : UINT32_MAX,
        .index = frame->data[1],
        .result = fixture_can_i16(frame, 2),
        .value = fixture_can_i32(frame, 4),
    };
}

int32_t fixture_can_i16(const hal_can_frame_t *frame, uint32_t at)
{
    return (int16_t)(uint16_t)(frame->data[at] | frame->data[at + 1] << 8);
}

int32_t fixture_can_i32(const hal_can_frame_t *frame, uint32_t at)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < 4u; i++) {
        value |= (uint32_t)frame->data[at + i] << (8u * i);
    }
    return (int32_t)value;
}

const char *fixture_can_line(uint32_t n_ago)
{
    const bool is_kept = n_ago < hal_host.n_lines && n_ago < hal_host_lines;
    return is_kept ? hal_host.lines[(hal_host.n_lines - 1u - n_ago) % hal_host_lines] : "";
}

cam_state_t fixture_can_state(const fixture_can_t *f)
{
    return fixture_rig_status(&f->rig).state;
}
