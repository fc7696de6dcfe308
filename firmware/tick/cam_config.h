// SPDX-License-Identifier: Apache-2.0
/// cam_config: parameters and table turned into what the interrupt needs, and the hand-over.
///
/// cam_config_build() does all divisions and all checks of fit on the slow side. The result goes
/// into the half of the bank that the interrupt does not use; the interrupt takes it at the start
/// of a tick and keeps it for that tick. No lock: one atomic index each way.
#ifndef CAM_CONFIG_H
#define CAM_CONFIG_H

#include "cam_err.h"     // cam_err_t
#include "cam_fence.h"   // cam_fence_acquire_isr
#include "cam_guard.h"   // cam_guard_config_t
#include "cam_param.h"   // cam_params_t
#include "cam_play.h"    // cam_play_config_t
#include "cam_spindle.h" // cam_spindle_config_t
#include <stdatomic.h>   // offered, in_use
#include <stdint.h>      // uint32_t

/// Everything that a tick reads and does not change.
typedef struct {
    cam_spindle_config_t spindle;
    cam_play_config_t play;
    cam_guard_config_t guard;
    cam_table_t table;   ///< play.table points here
    int32_t k1_q16;      ///< [ticks] velocity feed-forward
    int32_t k2_q16;      ///< [ticks^2] acceleration feed-forward
    uint32_t trace_room; ///< [records] of the trace ring that may wait for their reader
    uint32_t generation; ///< rises with every hand-over
} cam_config_t;

/// Two configurations, one in use.
typedef struct {
    const cam_config_t *_Atomic offered; ///< slow side writes: to be taken from the next tick on
    const cam_config_t *_Atomic in_use;  ///< interrupt writes: that of this tick
    cam_config_t half[2];
} cam_config_bank_t;

/// Derive a configuration.
/// @param config      result, complete on success
/// @param params      within their ranges
/// @param table       NULL when none is selected
/// @param speed_limit_mrpm  [r/min / 1000] beyond which overspeed is a fault
/// @param tick_hz,clock_hz  [Hz] of the port
/// @return cam_ok, or cam_err_param_tick when lead, bandwidth or feed-forward do not fit the tick
/// rate Context: slow side.
CAM_MUST_USE cam_err_t cam_config_build(cam_config_t *config, const cam_params_t *params,
                                        const cam_table_t *table, uint32_t speed_limit_mrpm,
                                        uint32_t tick_hz, uint32_t clock_hz);

/// @return the half that may be written now, NULL while the interrupt has not taken the last one.
/// Context: slow side.
cam_config_t *cam_config_free_half(cam_config_bank_t *bank);

/// Hand the free half over; it is in force from the next tick on. Context: slow side.
void cam_config_offer(cam_config_bank_t *bank);

/// @return the configuration of this tick. Context: ISR, constant time.
static inline __attribute__((always_inline)) const cam_config_t *
cam_config_take_isr(cam_config_bank_t *bank)
{
    const cam_config_t *offered = atomic_load_explicit(&bank->offered, memory_order_relaxed);
    cam_fence_acquire_isr();
    cam_fence_release_isr(); // what the last tick read of the other half was read before this
    atomic_store_explicit(&bank->in_use, offered, memory_order_relaxed);
    return offered;
}

/// @return [turn / 2^32 per tick] of a speed, rounded, saturated. Context: slow side.
int32_t cam_config_speed_q32(uint32_t speed_mrpm, uint32_t tick_hz);

#endif
