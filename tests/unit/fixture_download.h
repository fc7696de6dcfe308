// SPDX-License-Identifier: Apache-2.0
/// fixture_download: a controller started with one table, and another table that is brought to it
/// over CAN in small blocks, so that a download has many.
#ifndef FIXTURE_DOWNLOAD_H
#define FIXTURE_DOWNLOAD_H

#include "fixture_can.h"   // fixture_can_t, fixture_answer_t
#include "fixture_image.h" // fixture_image_t
#include <stdint.h>        // uint8_t, uint32_t

enum { fixture_block_bytes = 512 };

/// Commands.
enum { fixture_select = 8, fixture_begin = 16, fixture_end, fixture_block };

typedef struct {
    fixture_can_t can;
    fixture_part_t part;
    fixture_image_t other;
} fixture_download_t;

/// Start a controller with the table "short skirt", make the table "other skirt".
void fixture_download_init(fixture_download_t *d);

/// Make the other table anew, with a name of eleven characters.
void fixture_download_name(fixture_download_t *d, const char *name);

/// @return blocks of the other table, CRC-32 of it, bytes of its block i
uint32_t fixture_download_blocks(const fixture_download_t *d);
uint32_t fixture_download_crc(const fixture_download_t *d);
uint32_t fixture_download_bytes(const fixture_download_t *d, uint32_t i);

/// Send a command without a parameter. @return its answer
fixture_answer_t fixture_download_send(fixture_download_t *d, uint8_t command, uint32_t value);

/// A frame of a block arrives, a loop passes. @return false when the queue was full
bool fixture_download_frame(fixture_download_t *d, const uint8_t *data, uint32_t n);

/// A message by ISO-TP arrives, but for the last of its frames that are held back.
void fixture_download_message(fixture_download_t *d, const uint8_t *message, uint32_t length,
                              uint32_t n_held_back);

/// @param message  filled: offset, n bytes of an image from there on. @return [bytes] of it
uint32_t fixture_download_make(uint8_t *message, const uint8_t *image, uint32_t offset, uint32_t n);

/// Send a block of the other table. @return the answer
fixture_answer_t fixture_download_block(fixture_download_t *d, uint32_t offset, uint32_t n);

/// @return the newest answer
fixture_answer_t fixture_download_answer(void);

#endif
