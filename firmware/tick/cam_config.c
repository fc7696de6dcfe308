// SPDX-License-Identifier: Apache-2.0
#include "cam_config.h"
#include <stddef.h> // NULL

/// @return the half that is not offered
static cam_config_t *other_half(cam_config_bank_t *bank, const cam_config_t *offered)
{
    return offered == &bank->half[0] ? &bank->half[1] : &bank->half[0];
}

cam_config_t *cam_config_free_half(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    const cam_config_t *in_use = atomic_load_explicit(&bank->in_use, memory_order_acquire);
    return offered == in_use ? other_half(bank, offered) : NULL;
}

void cam_config_tie(cam_config_t *config, bool has_table)
{
    config->play.table = has_table ? &config->table : NULL;
    config->play.c = config->learned.c;
    config->play.d = config->learned.d;
    config->spindle.dm = config->learned.dm;
}

cam_config_t *cam_config_copy(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    cam_config_t *half = cam_config_free_half(bank);
    if (half != NULL && offered != NULL) {
        *half = *offered;
        cam_config_tie(half, offered->play.table != NULL);
        half->k1_q16 -= half->learned.k1_q16;
        half->k2_q16 -= half->learned.k2_q16;
    }
    return half;
}

void cam_config_learn(cam_config_t *config)
{
    config->k1_q16 += config->learned.k1_q16;
    config->k2_q16 += config->learned.k2_q16;
}

void cam_config_offer(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    atomic_store_explicit(&bank->offered, other_half(bank, offered), memory_order_release);
}
