// SPDX-License-Identifier: Apache-2.0
/// stm_params: stores parameters in flash, safe against power loss at any instant.
///
/// Two sectors hold a log. A record consists of the bytes, padded to whole flash words, followed by
/// one flash word, the seal. The seal is written last and in one operation; a record without a seal
/// is invalid:
///
///     | bytes .. | seal 7 | bytes .. | seal 8 | bytes, torn | erased ..
///
/// The sealed record with the highest number is current. Records are appended to its sector. When
/// it is full, the other one is erased and receives the next record, so the sector with the newest
/// record is never erased. Both sectors are in the bank of place 0.
#include "stm_memory.h"

enum { n_sectors = 2, n_words = stm_flash_sector_bytes / stm_flash_word_bytes };

extern const uint8_t stm_params_start[];

/// A flash word.
typedef struct {
    uint32_t words[stm_flash_words];
} word_t;
_Static_assert(sizeof(word_t) == stm_flash_word_bytes, "a seal is written at once");

static const uint32_t seal_magic = 0x4D524150u; // "PARM"

/// State of the log.
typedef struct {
    hal_params_t kept;
    uint32_t number; ///< of the current record, from 1; 0: none
    uint32_t sector; ///< sector of the current record
    uint32_t open;   ///< sector to which the next record is appended
    uint32_t next;   ///< flash word at which that record begins
} store_t;

static store_t store;

static uint32_t address_of(uint32_t sector, uint32_t i)
{
    return (uint32_t)(uintptr_t)stm_params_start + sector * stm_flash_sector_bytes +
           i * stm_flash_word_bytes;
}

/// @return number of flash words that hold the bytes of a record
static uint32_t words_of(uint32_t size)
{
    return (size + stm_flash_word_bytes - 1u) / stm_flash_word_bytes;
}

static word_t seal_of(uint32_t number, uint32_t size)
{
    return (word_t){{seal_magic, number, size, ~seal_magic, ~number, ~size, 0, 0}};
}

/// @return whether two flash words are the same
static bool is_same(const word_t *a, const word_t *b)
{
    bool is = true;
    for (uint32_t k = 0; k < stm_flash_words; k++) {
        is = is && a->words[k] == b->words[k];
    }
    return is;
}

/// Make the record whose seal is word i current if it is newer than the one found before.
/// @param begin  first word after the previous seal and after any unreadable word
/// @return       whether the word is a seal of readable bytes
static bool take_record(uint32_t sector, uint32_t begin, uint32_t i, const word_t *found)
{
    const uint32_t number = found->words[1];
    const uint32_t size = found->words[2];
    const word_t due = seal_of(number, size);
    if (!is_same(found, &due) || size == 0u || size > (uint32_t)hal_params_most_bytes ||
        words_of(size) > i - begin) {
        return false;
    }
    if (number > store.number) {
        const uint32_t address = address_of(sector, i - words_of(size));
        store.number = number;
        store.sector = sector;
        store.kept.bytes = (const char *)(uintptr_t)address;
        store.kept.size = size;
    }
    return true;
}

/// Scan a sector up to its first erased word.
/// @param n_used  result: number of words before it
/// @return        whether all of them belong to complete records
static bool read_sector(uint32_t sector, uint32_t *n_used)
{
    static const word_t erased = {{UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX,
                                   UINT32_MAX, UINT32_MAX, UINT32_MAX}};
    uint32_t begin = 0; // of the candidate bytes of the next seal
    uint32_t i = 0;
    for (; i < (uint32_t)n_words; i++) {
        word_t found;
        const bool is_readable = stm_flash_peek(address_of(sector, i), found.words);
        if (is_readable && is_same(&found, &erased)) {
            break;
        }
        begin = !is_readable || take_record(sector, begin, i, &found) ? i + 1u : begin;
    }
    *n_used = i;
    return begin == i;
}

void stm_params_init(void)
{
    uint32_t n_used[n_sectors];
    bool is_whole = true;
    store = (store_t){.number = 0};
    for (uint32_t sector = 0; sector < (uint32_t)n_sectors; sector++) {
        is_whole = read_sector(sector, &n_used[sector]) && is_whole;
    }
    store.kept.is_damaged = !is_whole;
    store.open = store.sector;
    // Without a record the state of the sectors is unknown, so the first save erases one.
    store.next = store.number > 0u ? n_used[store.open] : (uint32_t)n_words;
}

hal_params_t hal_params_kept(void)
{
    return store.kept;
}

/// Make room for a record: at the end of the open sector, or in the one without the kept record.
static bool make_room(uint32_t n)
{
    if (n <= (uint32_t)n_words - store.next) {
        return true;
    }
    store.open = store.number > 0u ? 1u - store.sector : 0u;
    const bool is_erased = stm_flash_erase(address_of(store.open, 0), stm_flash_sector_bytes);
    store.next = is_erased ? 0u : (uint32_t)n_words;
    return is_erased;
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    if (size == 0u || size > (uint32_t)hal_params_most_bytes || !make_room(words_of(size) + 1u)) {
        return false;
    }
    const uint32_t begin = address_of(store.open, store.next);
    const uint32_t end = begin + words_of(size) * stm_flash_word_bytes;
    const word_t seal = seal_of(store.number + 1u, size);
    // Append nothing after a failed write: the scan at the next start would stop there.
    const uint32_t next = store.next + words_of(size) + 1u;
    store.next = (uint32_t)n_words;
    if (!stm_flash_program(begin, (const uint8_t *)bytes, size) ||
        !stm_flash_program(end, (const uint8_t *)seal.words, sizeof seal)) {
        return false;
    }
    store.next = next;
    store.number++;
    store.sector = store.open;
    store.kept = (hal_params_t){.bytes = (const char *)(uintptr_t)begin, .size = size};
    return true;
}
