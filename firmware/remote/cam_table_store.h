// SPDX-License-Identifier: Apache-2.0
/// cam_table_store: the two slots for tables: one is in use, the other takes a download.
///
///     begin(size) -> block, block, .. -> end(crc) -> select
///
/// Only select replaces the table in use, and only by a download that is complete (CRC-32) and
/// passed cam_table_check(). Any error before, or a new begin, leaves the old table in
/// force. All steps need the state off or ready, in which no tick reads a table; in ready the new
/// table must also turn in the same sense and be feasible. All functions: slow side, main() only.
#ifndef CAM_TABLE_STORE_H
#define CAM_TABLE_STORE_H

#include "cam_err.h"     // cam_err_t
#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

enum {
    cam_table_store_block_header = 4,   ///< [bytes] offset of a block, the lowest byte first
    cam_table_store_block_bytes = 4096, ///< [bytes] of the image in a block, at most
};

/// @return the little-endian word at some bytes, such as the offset of a block
static inline uint32_t cam_table_store_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/// State; zero-initialised except for machine and err, which begins as cam_err_no_table.
typedef struct {
    cam_machine_t *machine; ///< initialised
    cam_err_t err;          ///< result of the last check of the table in use
    uint32_t generation;    ///< how often a table has been taken into use
    uint32_t size;          ///< [bytes] of the image that is being downloaded
    uint32_t received;      ///< [bytes] of it that have been stored
    bool is_open;           ///< a download has begun, blocks are accepted
    bool is_checked;        ///< the download is complete and good: the next select takes it
} cam_table_store_t;

/// Put a table into use: a complete download, else the table of the slot in use, checked again.
/// @return as cam_machine_select_table(); cam_err_no_table if the slot is empty;
///         cam_err_download_store if the port could not store the download: the old table stays in
///         force, and every further select tries again until a new download begins
/// Context: lasts as long as cam_table_check() and, after a download, hal_table_commit().
CAM_MUST_USE cam_err_t cam_table_store_select(cam_table_store_t *s);

/// @return whether an error of cam_table_store_select() is temporary (state, busy, store), not the
///         result of the table's check
bool cam_table_store_is_of_moment(cam_err_t err);

/// Begin a download: empty the other place. What was downloaded before is lost.
/// @param size  [bytes] of the image
/// @return cam_ok, cam_err_state, cam_err_busy, cam_err_image_size (less than a header),
///         cam_err_download_room (larger than the place, or the place cannot be emptied)
/// Context: lasts as long as hal_table_begin().
CAM_MUST_USE cam_err_t cam_table_store_begin(cam_table_store_t *s, uint32_t size);

/// Store the next block. A block that is stored already is accepted without being written again.
/// @param block  n bytes: the offset, then bytes of the image; every block but the last holds a
///               multiple of hal_table_grain
/// @return cam_ok; cam_err_state, cam_err_busy; cam_err_download_order: nothing has changed, and
///         `received` is the offset of the block that is due; cam_err_download_room: beyond the
///         announced size; cam_err_download_store: the download has to begin anew
/// Context: lasts as long as hal_table_write().
CAM_MUST_USE cam_err_t cam_table_store_block(cam_table_store_t *s, const uint8_t *block,
                                             uint32_t n);

/// End a download: check what has been stored.
/// @param crc  CRC-32 of all bytes of the image, as sent
/// @return cam_ok: the next select takes the table; cam_err_state, _busy, cam_err_download_order,
///         _short: the download may go on; cam_err_download_crc or an error of
///         cam_table_check(): the download has to begin anew
/// Context: lasts as long as cam_table_check().
CAM_MUST_USE cam_err_t cam_table_store_end(cam_table_store_t *s, uint32_t crc);

#endif
