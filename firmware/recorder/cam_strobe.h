// SPDX-License-Identifier: Apache-2.0
/// cam_strobe: samples for a live view of the following error over the angle.
///
///     subscription: every n-th tick -> sample -> queue -> message Strobe (cam_can.c)
///
/// The slow side samples the records of the trace ring (cam_machine_scope.h), independently of
/// recorder and black box. A subscription ends cam_strobe_hold_s after it was last renewed. A lost
/// record or a full queue leaves a gap in the sample numbers. Context: slow side.
#ifndef CAM_STROBE_H
#define CAM_STROBE_H

#include "cam_record.h" // cam_tick_record_t
#include "cam_state.h"  // cam_state_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

enum {
    cam_strobe_hz = 500,      ///< [Hz] samples at most: an eighth of a bus of 500 kbit/s
    cam_strobe_hold_s = 2,    ///< [s] for which a subscription is valid
    cam_strobe_capacity = 16, ///< [samples] of the queue, a power of two
};

/// Sample of one tick.
typedef struct {
    uint32_t number;      ///< since the subscription began, including lost samples
    uint32_t pos_q16;     ///< [turn / 2^16] master position in the sense of cutting, rounded down
    int32_t following_nm; ///< [nm] U measured less U due
    cam_state_t state;
    bool is_synced; ///< the angle is known
} cam_strobe_sample_t;

/// State; zero-initialised is without a subscription.
typedef struct {
    uint32_t every;        ///< [ticks] between samples; 0: no subscription
    uint32_t renewed_tick; ///< last renewal
    uint32_t next_tick;    ///< of the next sample
    uint32_t number;       ///< of the next sample
    uint32_t n_lost;       ///< samples lost since the start
    uint32_t n_in, n_out;  ///< samples queued and taken
    cam_strobe_sample_t queue[cam_strobe_capacity];
} cam_strobe_t;

/// @param tick_hz  [Hz]
/// @return         [ticks] shortest interval between samples
uint32_t cam_strobe_least(uint32_t tick_hz);

/// Start a subscription, or renew it with the same interval.
/// @param every  [ticks] cam_strobe_least() .. tick rate; 0 ends it
/// @param tick   newest tick; samples are later
void cam_strobe_subscribe(cam_strobe_t *s, uint32_t every, uint32_t tick);

/// @return whether there is a subscription
static inline bool cam_strobe_is_on(const cam_strobe_t *s)
{
    return s->every != 0u;
}

/// Process a record, in the order of the ticks.
void cam_strobe_take(cam_strobe_t *s, const cam_tick_record_t *r);

/// End a subscription that was not renewed. @param tick  newest tick
void cam_strobe_expire(cam_strobe_t *s, uint32_t tick, uint32_t tick_hz);

/// @return oldest sample in the queue, NULL: none
const cam_strobe_sample_t *cam_strobe_oldest(const cam_strobe_t *s);

/// Remove the oldest sample.
void cam_strobe_drop(cam_strobe_t *s);

#endif
