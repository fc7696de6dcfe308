// SPDX-License-Identifier: Apache-2.0
#include "cam_config.h"
#include "cam_fix.h" // cam_abs_i64, cam_clamp_i64
#include <stddef.h>  // NULL

/// [nm] largest step of the command of U when learned values change, all of them at once.
#define LEARNED_STEP_NM 1900

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
    }
    return half;
}

void cam_config_learn(cam_config_t *config)
{
    cam_axis_command_config_t *t = &config->command;
    t->in_cut.k1_q16 = t->configured.k1_q16 + config->learned.k1_q16;
    t->in_cut.k2_q16 = t->configured.k2_q16 + config->learned.k2_q16;
    t->in_cut.friction_q14 = t->configured.friction_q14 + config->learned.friction_q6 * 256;
    t->in_cut.chip_q32 = config->learned.chip_q32;
    t->in_cut.chip_q6 = config->learned.chip_q6;
    cam_config_limit_command(config);
}

static int64_t larger(int32_t a, int32_t b)
{
    return cam_abs_i64(a) > cam_abs_i64(b) ? cam_abs_i64(a) : cam_abs_i64(b);
}

/// @return [nm] limit rounded up, plus a learned correction's step; at most 2^29: sums fit a word
static int32_t limit_nm(int64_t q10)
{
    return (int32_t)cam_clamp_i64(q10 / 1024 + 1 + LEARNED_STEP_NM, 0, INT64_C(1) << 29);
}

void cam_config_limit_command(cam_config_t *config)
{
    cam_guard_config_t *g = &config->guard;
    const cam_axis_command_config_t *t = &config->command;
    const int64_t k1_q16 = larger(t->configured.k1_q16, t->in_cut.k1_q16);
    const int64_t k2_q16 = larger(t->configured.k2_q16, t->in_cut.k2_q16);
    const int64_t v_q10 = (int64_t)g->u_vel_q6 * 16;
    const int64_t a_q10 = (int64_t)g->u_acc_q6 * 16;
    const int64_t j_q10 = 2 * a_q10 / (INT64_C(1) << g->u.log2_window) + 1;
    const int64_t reversed_q10 = cam_abs_i64(t->in_cut.friction_q14) / 8; // twice the friction
    const int64_t chip_q32 = cam_abs_i64(t->in_cut.chip_q32);
    const int64_t step_q10 = v_q10 + k1_q16 * a_q10 / 65536 + k2_q16 * j_q10 / 65536 +
                             (chip_q32 * v_q10 >> 32) + reversed_q10;
    const int64_t change_q10 = a_q10 + k1_q16 * j_q10 / 65536 + 2 * (k2_q16 * j_q10 / 65536) +
                               (chip_q32 * a_q10 >> 32) + reversed_q10;
    g->step_nm = limit_nm(step_q10);
    g->change_nm = limit_nm(change_q10);
    g->change_off_nm = limit_nm(change_q10 + step_q10);
}

void cam_config_offer(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    cam_config_t *half = other_half(bank, offered);
    atomic_store_explicit(&bank->offered, half, memory_order_release);
}
