// SPDX-License-Identifier: Apache-2.0
#include "stm_memory.h"

enum { text_words = 30, text_bytes = 4 * text_words };

/// The kept text with its check word. It consists of whole words, because the error-correction code
/// of the DTCM covers words.
typedef struct {
    uint32_t magic;
    uint32_t text[text_words]; ///< four characters each, the first in the lowest byte
    uint32_t check;
} keep_t;

__attribute__((section(".keep"))) static volatile keep_t keep;

static const uint32_t keep_magic = 0x48414C54u; // "HALT"

/// Text of the halt before this start.
static char why[text_bytes + 1];

/// @return the check word that belongs to the kept text
static uint32_t check_word(void)
{
    uint32_t check = keep_magic;
    for (uint32_t i = 0; i < text_words; i++) {
        check = (check << 5 | check >> 27) ^ keep.text[i];
    }
    return check;
}

void stm_keep_text(const char *text)
{
    bool has_ended = false;
    for (uint32_t i = 0; i < text_words; i++) {
        uint32_t word = 0;
        for (uint32_t j = 0; j < 4u; j++) {
            const char c = has_ended ? '\0' : text[4u * i + j];
            has_ended = c == '\0';
            word |= (uint32_t)(uint8_t)c << 8u * j;
        }
        keep.text[i] = word;
    }
    keep.check = check_word();
    keep.magic = keep_magic;
    stm_barrier();
}

/// Copy a kept text to `why`.
/// @return whether there was one
static bool take_text(void)
{
    const bool is_valid = keep.magic == keep_magic && keep.check == check_word();
    for (uint32_t i = 0; is_valid && i < text_bytes; i++) {
        why[i] = (char)(keep.text[i / 4u] >> 8u * (i % 4u) & 0xFFu);
    }
    return is_valid;
}

/// Power-on also sets the brown-out flag, and every internal reset also sets the pin flag, so check
/// the flags from the most to the least specific.
static hal_reset_t reason(uint32_t flags, bool has_text)
{
    if ((flags & RCC_RSR_PORRSTF) != 0u) {
        return hal_reset_power_on;
    }
    if ((flags & RCC_RSR_BORRSTF) != 0u) {
        return hal_reset_brown_out;
    }
    if ((flags & (RCC_RSR_IWDG1RSTF | RCC_RSR_WWDG1RSTF)) != 0u) {
        return hal_reset_watchdog;
    }
    if ((flags & RCC_RSR_SFTRSTF) != 0u) {
        return has_text ? hal_reset_halt : hal_reset_software;
    }
    return hal_reset_pin;
}

hal_start_t stm_keep_start(void)
{
    const uint32_t flags = RCC_RSR;
    const bool has_text = stm_keep_may_hold(flags) && take_text();
    keep.magic = 0;
    RCC_RSR |= RCC_RSR_RMVF;
    return (hal_start_t){.reset = reason(flags, has_text), .why = why};
}
