// SPDX-License-Identifier: Apache-2.0
#include "cam_scrub.h"
#include "cam_seal.h" // cam_seal_more
#include <stddef.h>   // offsetof, NULL

enum { sealed_words = offsetof(cam_config_t, seal) / sizeof(uint32_t) };

bool cam_scrub_step(cam_scrub_t *s, const cam_config_bank_t *bank)
{
    const cam_config_t *config = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    if (config == NULL) {
        return true;
    }
    if (config != s->config || config->generation != s->generation) {
        *s = (cam_scrub_t){.config = config, .generation = config->generation};
    }
    const uint32_t left = (uint32_t)sealed_words - s->at;
    const uint32_t n = left < (uint32_t)cam_scrub_words ? left : (uint32_t)cam_scrub_words;
    const unsigned char *words = (const unsigned char *)config;
    s->sum = cam_seal_more(s->sum, &words[s->at * sizeof(uint32_t)], n);
    s->at += n;
    if (s->at < (uint32_t)sealed_words) {
        return true;
    }
    const bool is_whole = s->sum == config->seal;
    s->at = 0;
    s->sum = 0;
    return is_whole;
}
