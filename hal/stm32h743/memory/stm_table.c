// SPDX-License-Identifier: Apache-2.0
/// stm_table: two slots for tables in flash and the switch between them (hal_table_*()).
///
/// The places are in different banks. A log in a sector of its own records which one is in use. A
/// record is one flash word, so it is written completely or not at all. The last good record
/// applies; an empty log means place 0, which programming tools write. The log is erased only while
/// place 0 is in use, so erasing it does not change the place in use.
///
/// Older firmware, which fitted in one sector, had place 1 at sector 1, where code is now. Records
/// of that old place have the name 1, those of the present place 1 the name 2. A table in the old
/// place is lost. Place 0 may hold a table of another part, so no table is used until a new one is
/// downloaded or programmed.
#include "stm_memory.h"
#include <stddef.h> // NULL

enum { n_records = 1024 };

/// Names of places in a record.
enum { name_place_0 = 0, name_old_place_1 = 1, name_place_1 = 2, n_names = 3 };

extern const uint8_t stm_table_start[], stm_table_bytes[];
extern const uint8_t stm_other_start[], stm_other_bytes[], stm_log_start[];

/// A record of the log: magic, name of the place, its own number, and the complements of these.
typedef struct {
    uint32_t words[stm_flash_words];
} record_t;
_Static_assert(sizeof(record_t) == stm_flash_word_bytes, "a record is written at once");
_Static_assert(hal_table_grain % stm_flash_word_bytes == 0, "pieces are whole flash words");

static const uint32_t record_magic = 0x4C424154u; // "TABL"

static uint32_t in_use;    ///< place in use, 0 or 1
static bool is_lost;       ///< the table in use was in the old place 1
static uint32_t n_written; ///< number of records in the log, good or torn
static bool is_begun;      ///< a download has begun

/// @return address of record i of the log
static uint32_t log_address(uint32_t i)
{
    return (uint32_t)stm_log_start + i * stm_flash_word_bytes;
}

/// @return record i of the log, which makes the named place the one in use
static record_t record_of(uint32_t name, uint32_t i)
{
    return (record_t){{record_magic, name, i, ~record_magic, ~name, ~i, 0, 0}};
}

/// @return whether a flash word is a good record i
static bool is_record(const record_t *found, uint32_t i)
{
    const record_t due = record_of(found->words[1], i);
    bool is_good = found->words[1] < n_names;
    for (uint32_t k = 0; k < stm_flash_words; k++) {
        is_good = is_good && found->words[k] == due.words[k];
    }
    return is_good;
}

/// @return whether a flash word is erased
static bool is_empty(const record_t *found)
{
    uint32_t all = UINT32_MAX;
    for (uint32_t k = 0; k < stm_flash_words; k++) {
        all &= found->words[k];
    }
    return all == UINT32_MAX;
}

void stm_table_init(void)
{
    uint32_t name = name_place_0;
    n_written = 0;
    is_begun = false;
    for (uint32_t i = 0; i < n_records; i++) {
        record_t found;
        const bool is_readable = stm_flash_peek(log_address(i), found.words);
        if (is_readable && is_record(&found, i)) {
            name = found.words[1];
        }
        n_written = is_readable && is_empty(&found) ? n_written : i + 1u;
    }
    in_use = name == name_place_0 ? 0u : 1u;
    is_lost = name == name_old_place_1;
}

bool stm_table_is_lost(void)
{
    return is_lost;
}

/// @return place 0 or 1 for a table
static hal_image_t place(uint32_t i)
{
    return i == 0u ? (hal_image_t){.bytes = stm_table_start, .size = (uint32_t)stm_table_bytes}
                   : (hal_image_t){.bytes = stm_other_start, .size = (uint32_t)stm_other_bytes};
}

/// If programming was interrupted, some words cannot be read, and loading one would cause a bus
/// fault and a reset at every start. The image ends before them, so the table is truncated and
/// refused.
hal_image_t hal_table_image(void)
{
    const hal_image_t all = place(in_use);
    const uint32_t size = is_lost ? 0u : stm_flash_readable((uint32_t)all.bytes, all.size);
    return (hal_image_t){.bytes = all.bytes, .size = size};
}

hal_image_t hal_table_staged(void)
{
    return is_begun ? place(1u - in_use) : (hal_image_t){.bytes = NULL, .size = 0};
}

/// @return whether the log has room for the next record, after an erase if necessary
static bool make_room_in_log(void)
{
    if (in_use == 0u && n_written > n_records / 2u) {
        n_written = 0;
        return stm_flash_erase((uint32_t)stm_log_start, stm_flash_sector_bytes);
    }
    return n_written < n_records;
}

/// The size of the smaller place is the limit for both, so that a table that fits once fits again.
bool hal_table_begin(uint32_t size)
{
    is_begun = false;
    if (size == 0u || size > (uint32_t)stm_other_bytes || !make_room_in_log()) {
        return false;
    }
    is_begun = stm_flash_erase((uint32_t)place(1u - in_use).bytes, size);
    return is_begun;
}

bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    const hal_image_t to = hal_table_staged();
    const bool is_inside = offset <= to.size && n <= to.size - offset;
    return is_begun && is_inside && offset % stm_flash_word_bytes == 0u &&
           stm_flash_program((uint32_t)to.bytes + offset, (const uint8_t *)bytes, n);
}

bool hal_table_commit(void)
{
    if (!is_begun || n_written == n_records) {
        return false;
    }
    // Count the record before writing: a torn one also uses up its entry in the log.
    const record_t record = record_of(in_use == 0u ? name_place_1 : name_place_0, n_written);
    const uint32_t address = log_address(n_written);
    n_written++;
    is_begun = false;
    hal_idle(); // feed the watchdog between the table checks before and after
    if (!stm_flash_program(address, (const uint8_t *)record.words, sizeof record)) {
        return false;
    }
    in_use = 1u - in_use;
    is_lost = false;
    return true;
}
