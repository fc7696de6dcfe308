// SPDX-License-Identifier: Apache-2.0
#include "fixture_download.h"
#include "hal_host.h" // hal_host_can_receive
#include <string.h>   // memcpy

void fixture_download_name(fixture_download_t *d, const char *name)
{
    fixture_image_make(&d->other, &d->part);
    memcpy(d->other.bytes + fixture_at_name, name, 11);
    fixture_image_seal(&d->other);
}

void fixture_download_init(fixture_download_t *d)
{
    d->part = fixture_part_short();
    fixture_download_name(d, "other skirt");
    fixture_can_init(&d->can, &d->part, 20000);
    fixture_can_start(&d->can);
    fixture_can_loop(&d->can, 1);
}

uint32_t fixture_download_blocks(const fixture_download_t *d)
{
    return ((uint32_t)d->other.size + fixture_block_bytes - 1u) / fixture_block_bytes;
}

uint32_t fixture_download_crc(const fixture_download_t *d)
{
    return cam_crc32(0, d->other.bytes, d->other.size);
}

uint32_t fixture_download_bytes(const fixture_download_t *d, uint32_t i)
{
    const uint32_t left = (uint32_t)d->other.size - i * fixture_block_bytes;
    return left < fixture_block_bytes ? left : fixture_block_bytes;
}

fixture_answer_t fixture_download_send(fixture_download_t *d, uint8_t command, uint32_t value)
{
    return fixture_can_command(&d->can, command, 0, (int32_t)value);
}

bool fixture_download_frame(fixture_download_t *d, const uint8_t *data, uint32_t n)
{
    hal_can_frame_t frame = {.id = 0x6C0, .n = n};
    memcpy(frame.data, data, n);
    const bool is_received = hal_host_can_receive(&frame);
    fixture_can_loop(&d->can, 1);
    return is_received;
}

void fixture_download_message(fixture_download_t *d, const uint8_t *message, uint32_t length,
                              uint32_t n_held_back)
{
    const uint32_t n_frames = 1u + length / 7u - n_held_back; // six bytes in the first
    uint8_t data[8] = {(uint8_t)length};
    if (length < 8u) {
        memcpy(data + 1, message, length);
        (void)fixture_download_frame(d, data, 8);
        return;
    }
    data[0] = (uint8_t)(0x10u | length >> 8);
    data[1] = (uint8_t)length;
    memcpy(data + 2, message, 6);
    (void)fixture_download_frame(d, data, 8);
    for (uint32_t i = 1; i < n_frames; i++) {
        const uint32_t at = 6u + 7u * (i - 1u);
        const uint32_t n = length - at < 7u ? length - at : 7u;
        data[0] = (uint8_t)(0x20u | i % 16u);
        memcpy(data + 1, message + at, n);
        (void)fixture_download_frame(d, data, 1u + n);
    }
}

uint32_t fixture_download_make(uint8_t *message, const uint8_t *image, uint32_t offset, uint32_t n)
{
    for (uint32_t i = 0; i < 4u; i++) {
        message[i] = (uint8_t)(offset >> (8u * i));
    }
    memcpy(message + 4, image + offset, n);
    return 4u + n;
}

fixture_answer_t fixture_download_answer(void)
{
    const hal_can_frame_t frame = fixture_can_sent(0x5C0);
    return fixture_can_answer(&frame);
}

fixture_answer_t fixture_download_block(fixture_download_t *d, uint32_t offset, uint32_t n)
{
    uint8_t message[4 + fixture_block_bytes];
    fixture_download_message(d, message, fixture_download_make(message, d->other.bytes, offset, n),
                             0);
    return fixture_download_answer();
}
