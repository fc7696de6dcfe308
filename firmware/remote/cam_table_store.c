// SPDX-License-Identifier: Apache-2.0
#include "cam_remote_inner.h"
#include <stddef.h> // NULL
#include <string.h> // memcmp

/// Offset of the field image_size in the header of an image (TABLE_FORMAT.md).
enum { at_image_size = 16 };

// Select

/// Select the table in the slot in use. The slot may be larger than the image, whose header then
/// gives the size. If that size is impossible, the whole slot is offered, and cam_table_check()
/// finds the error.
static cam_err_t select_in_place(cam_machine_t *m)
{
    const hal_image_t place = hal_table_image();
    if (place.bytes == NULL || place.size == 0u) {
        return cam_err_no_table;
    }
    uint32_t size = place.size;
    if (place.size >= cam_table_header_size) {
        const uint32_t stored = cam_table_store_word((const uint8_t *)place.bytes + at_image_size);
        if (stored >= cam_table_header_size && stored < place.size) {
            size = stored;
        }
    }
    return cam_machine_select_table(m, place.bytes, size);
}

/// Make the slot of the download the one in use. The table is checked first, as nothing may refuse
/// it afterwards.
static cam_err_t take_downloaded(cam_table_store_t *s)
{
    cam_err_t err = cam_machine_may_exchange(s->machine);
    if (err == cam_ok) {
        err = cam_machine_check_table(s->machine, hal_table_staged().bytes, s->size);
    }
    if (err != cam_ok) {
        return err;
    }
    // After a failure the download stays pending, so that the next select does not silently take
    // the old table.
    s->is_checked = !hal_table_commit();
    return s->is_checked ? cam_err_download_store : cam_ok;
}

bool cam_table_store_is_of_moment(cam_err_t err)
{
    return err == cam_err_state || err == cam_err_busy || err == cam_err_download_store ||
           err == cam_err_table_sense;
}

cam_err_t cam_table_store_select(cam_table_store_t *s)
{
    cam_err_t err = s->is_checked ? take_downloaded(s) : cam_ok;
    if (err != cam_ok) {
        return err; // the table in use and the result of its check stay
    }
    err = select_in_place(s->machine);
    if (!cam_table_store_is_of_moment(err)) {
        s->err = err;
    }
    // Counting successful selects lets a tool recognise its own.
    s->generation += err == cam_ok ? 1u : 0u;
    return err;
}

// Download

cam_err_t cam_table_store_begin(cam_table_store_t *s, uint32_t size)
{
    const cam_err_t err = cam_machine_may_exchange(s->machine);
    if (err != cam_ok) {
        return err;
    }
    // After a commit without a select, the machine still uses the table in the slot that would be
    // erased.
    if (s->machine->has_table && s->machine->table.image != hal_table_image().bytes) {
        return cam_err_state;
    }
    if (size < cam_table_header_size) {
        return cam_err_image_size;
    }
    s->is_checked = false;
    s->is_open = hal_table_begin(size);
    s->size = size;
    s->received = 0;
    return s->is_open ? cam_ok : cam_err_download_room;
}

cam_err_t cam_table_store_block(cam_table_store_t *s, const uint8_t *block, uint32_t n)
{
    const cam_err_t err = cam_machine_may_exchange(s->machine);
    if (err != cam_ok) {
        return err;
    }
    if (!s->is_open || n <= cam_table_store_block_header) {
        return cam_err_download_order;
    }
    const uint32_t offset = cam_table_store_word(block);
    const uint8_t *bytes = &block[cam_table_store_block_header];
    const uint32_t n_bytes = n - cam_table_store_block_header;
    if (offset > s->size || n_bytes > s->size - offset) {
        return cam_err_download_room;
    }
    const uint8_t *staged = (const uint8_t *)hal_table_staged().bytes;
    if (offset + n_bytes <= s->received && memcmp(&staged[offset], bytes, n_bytes) == 0) {
        return cam_ok; // sent again because its acknowledgement was lost
    }
    const bool is_whole = n_bytes % hal_table_grain == 0u || offset + n_bytes == s->size;
    if (offset != s->received || !is_whole) {
        return cam_err_download_order;
    }
    if (!hal_table_write(offset, bytes, n_bytes)) {
        s->is_open = false;
        return cam_err_download_store;
    }
    s->received += n_bytes;
    return cam_ok;
}

cam_err_t cam_table_store_end(cam_table_store_t *s, uint32_t crc)
{
    cam_err_t err = cam_machine_may_exchange(s->machine);
    if (err != cam_ok) {
        return err;
    }
    if (!s->is_open) {
        return cam_err_download_order;
    }
    if (s->received < s->size) {
        return cam_err_download_short;
    }
    // A download takes no further blocks, even if its check fails.
    s->is_open = false;
    const hal_image_t staged = hal_table_staged();
    if (cam_crc32(0, staged.bytes, s->size) != crc) {
        return cam_err_download_crc;
    }
    cam_table_t table;
    err = cam_table_check(staged.bytes, s->size, &table);
    s->is_checked = err == cam_ok;
    return err;
}
