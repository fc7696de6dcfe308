// SPDX-License-Identifier: Apache-2.0
/// cam_store: the table's place: take what is in it into use, and bring a new table beside it.
///
///     begin(size) -> block, block, .. -> end(crc) -> select
///
/// Only the last step touches the table in use, and only when the new one is whole: its bytes are
/// those that were meant (CRC-32), and cam_table_check() finds it good. Whatever goes wrong before,
/// or a begin anew, leaves the old table in force. A download goes on in state off only.
/// All functions: slow side, main() only.
#ifndef CAM_STORE_H
#define CAM_STORE_H

#include "cam_err.h"     // cam_err_t
#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

enum {
    cam_store_block_header = 4,   ///< [bytes] offset of a block, the lowest byte first
    cam_store_block_bytes = 4096, ///< [bytes] of image in a block, at most
};

/// State.
typedef struct {
    cam_machine_t *machine;
    cam_err_t err;       ///< of the last check of the table in its place
    uint32_t generation; ///< times that a table was taken into use
    uint32_t size;       ///< [bytes] of the image that is downloaded
    uint32_t received;   ///< [bytes] of it that are stored
    bool is_open;        ///< blocks are taken
    bool is_checked;     ///< the next select takes the downloaded table
} cam_store_t;

void cam_store_init(cam_store_t *s, cam_machine_t *machine);

/// Take into use: the downloaded table, if one is complete; else check the one in its place anew.
/// @return as cam_machine_select_table(), cam_err_no_table; the downloaded one in state off only.
///         cam_err_download_store: the port could not keep it, the old one stays in force; so it is
///         with every select until one succeeds or a download begins anew
/// Context: lasts as long as cam_table_check(), on a Cortex-M7 about 26 instructions per byte of
/// the image, 65 with a speed channel; when a download is taken, once more the port's commit.
CAM_MUST_USE cam_err_t cam_store_select(cam_store_t *s);

/// @return whether an error of select tells of the moment, not of the table
bool cam_store_is_of_moment(cam_err_t err);

/// Make room; what was downloaded before is lost.
/// @param size  [bytes] of the image
/// @return cam_ok, cam_err_state, cam_err_busy, cam_err_image_size (less than a header),
///         cam_err_download_room (larger than the place, or the place cannot be emptied)
CAM_MUST_USE cam_err_t cam_store_begin(cam_store_t *s, uint32_t size);

/// Store the next block, or find that it is stored already.
/// @param block  n bytes: offset, image; all but the last hold a multiple of hal_table_grain
/// @return cam_ok, cam_err_state, cam_err_busy, cam_err_download_order (nothing changes; received
///         tells where to go on), cam_err_download_room (beyond the announced size), _store (begin
///         anew)
CAM_MUST_USE cam_err_t cam_store_block(cam_store_t *s, const uint8_t *block, uint32_t n);

/// Check what was downloaded.
/// @param crc  CRC-32 of all its bytes
/// @return cam_ok: select takes it; cam_err_state, _busy, cam_err_download_order, _short: go on;
///         cam_err_download_crc or what cam_table_check() found: begin anew
CAM_MUST_USE cam_err_t cam_store_end(cam_store_t *s, uint32_t crc);

#endif
