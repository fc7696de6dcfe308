// SPDX-License-Identifier: Apache-2.0
#include "cam_record.h"
#include "cam_fix.h" // cam_fence_release_isr
#include <stddef.h>  // NULL, size_t
#include <string.h>  // memset

/// Turns are numbered modulo 2^24; this bit marks a number as valid.
#define IS_TURN (UINT32_C(1) << 24)

static uint32_t numbered(uint32_t turn)
{
    return (turn & (IS_TURN - 1u)) | IS_TURN;
}

/// @return ticks to leave out after each that counts, so that a turn counts at most 2^14, MATHS.md
///         (232)
static uint32_t skip_at(int32_t speed_q32)
{
    enum { zeros = 13, most = 6 }; // before a bit of 2^18
    const int32_t log2 = __builtin_clz((uint32_t)speed_q32 | 1u) - zeros;
    return (1u << (uint32_t)cam_clamp_i32(log2, 0, most)) - 1u;
}

static void open_turn(cam_turn_bins_t *g, uint32_t turn, const cam_tick_record_t *r)
{
    const uint32_t cleared = atomic_load_explicit(&g->cleared[turn & 1u], CAM_ORDER_ACQUIRE);
    g->is_clean = cleared == numbered(turn);
    cam_turn_t *now = &g->now;
    now->turn = turn;
    now->state = r->want.state;
    now->is_steady = true;
    now->is_level = true;
    now->z_begin_nm = r->want.z_nm;
    now->skip = skip_at(r->angle.speed_q32);
}

static void close_turn(cam_turn_bins_t *g, uint32_t next)
{
    const cam_turn_t *now = &g->now;
    const uint32_t bank = now->turn & 1u;
    const bool is_good = g->is_clean && next == ((now->turn + 1u) & (IS_TURN - 1u));
    g->closed[bank] = *now;
    cam_fence_release_isr();
    atomic_store_explicit(&g->closed_turn[bank], is_good ? numbered(now->turn) : 0u,
                          CAM_ORDER_RELEASE);
}

void cam_turn_bins_plan_isr(cam_turn_bins_t *g, const cam_tick_record_t *r, const cam_motion_t *m)
{
    const uint32_t at_q8 = (uint32_t)((uint64_t)r->angle.pos_q32 >> 24);
    const uint32_t turn = at_q8 >> 8;
    cam_turn_t *now = &g->now;
    if (turn != now->turn) {
        close_turn(g, turn);
        open_turn(g, turn, r);
    }
    now->is_steady =
        now->is_steady && m->is_playing && m->phase_step_q32 == 0 && r->want.state == now->state;
    now->is_level = now->is_level && m->scale_step_q30 == 0;
    now->speed_q32 = r->angle.speed_q32;
    now->scale_q30 = m->scale_q30;
    now->phase_q32 = m->phase_q32;
    now->z_end_nm = r->want.z_nm;
    atomic_store_explicit(&g->z_vel_q10, m->axis[hal_axis_z].vel_q10, memory_order_relaxed);
    cam_fence_release_isr(); // what was closed is complete before the turn is seen to be over
    atomic_store_explicit(&g->at_q8, at_q8, CAM_ORDER_RELEASE);
}

static cam_turn_bin_t *bank_of(cam_turn_bins_t *g, uint32_t bank)
{
    return &g->bin[bank != 0u ? cam_turn_bins_n : 0];
}

/// Clear the bank that is idle during a turn. Mark it as clean unless the interrupt may have
/// reached the next turn meanwhile: a plan is at most a quarter turn old, or the turn is too short
/// to learn from. A late mark is harmless, because the interrupt has opened that turn as not clean.
/// @return whether it was in time
static bool clear(cam_turn_bins_t *g, uint32_t turn)
{
    const uint32_t bank = (turn + 1u) & 1u;
    (void)memset(bank_of(g, bank), 0, (size_t)cam_turn_bins_n * sizeof g->bin[0]);
    atomic_thread_fence(memory_order_acq_rel);
    const uint32_t at_q8 = atomic_load_explicit(&g->at_q8, memory_order_acquire);
    const bool is_in_time = at_q8 >> 8 == turn && (at_q8 & 0xFFu) < 192u;
    if (is_in_time) {
        atomic_store_explicit(&g->cleared[bank], numbered(turn + 1u), memory_order_release);
    }
    return is_in_time;
}

const cam_turn_bin_t *cam_turn_bins_take(cam_turn_bins_t *g, cam_turn_t *turn)
{
    const uint32_t now = atomic_load_explicit(&g->at_q8, memory_order_acquire) >> 8;
    const uint32_t bank = (now + 1u) & 1u;
    const uint32_t before = numbered(now - 1u);
    const uint32_t closed = atomic_load_explicit(&g->closed_turn[bank], memory_order_acquire);
    if (closed == before && g->taken != before) {
        g->taken = before;
        *turn = g->closed[bank];
        return bank_of(g, bank);
    }
    if (atomic_load_explicit(&g->cleared[bank], memory_order_relaxed) != numbered(now + 1u)) {
        (void)clear(g, now);
    }
    return NULL;
}

bool cam_turn_bins_release(cam_turn_bins_t *g)
{
    return clear(g, (g->taken + 1u) & (IS_TURN - 1u));
}
