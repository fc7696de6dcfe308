// SPDX-License-Identifier: Apache-2.0
/// cam_strobe: samples of single ticks for a live picture of the following error over the angle.
///
///     asked for: every n-th tick -> sample -> queue -> message Strobe (cam_can_strobe.c)
///
/// The slow side takes the samples from the records of the trace ring (cam_machine_scope.h), so
/// that the interrupt pays nothing, and recorder and black box are left alone. A subscription ends
/// cam_strobe_hold_s after it was asked for or renewed last, so a reader that is gone costs
/// nothing. Samples are numbered; one whose record was lost, or which finds the queue full, leaves
/// a gap in the numbers. Context: slow side.
#ifndef CAM_STROBE_H
#define CAM_STROBE_H

#include "cam_record.h" // cam_tick_record_t
#include "cam_state.h"  // cam_state_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

enum {
    cam_strobe_hz = 500,      ///< [Hz] samples at most: an eighth of a bus of 500 kbit/s
    cam_strobe_hold_s = 2,    ///< [s] that a subscription holds
    cam_strobe_capacity = 16, ///< [samples] of the queue, a power of two
};

/// What a tick tells; all of it is of the same record.
typedef struct {
    uint32_t number;      ///< of the sample since the subscription began, lost ones counted
    uint32_t pos_q16;     ///< [turn / 2^16] master position in the sense of cutting, rounded down
    int32_t following_nm; ///< [nm] U measured less U due
    cam_state_t state;
    bool is_synced; ///< the angle is known
} cam_strobe_sample_t;

/// State; zero-initialised is asked for by nobody.
typedef struct {
    uint32_t every;        ///< [ticks] between samples; 0: nobody asks
    uint32_t renewed_tick; ///< when it was asked for last
    uint32_t next_tick;    ///< of the next sample
    uint32_t number;       ///< of the next sample
    uint32_t n_lost;       ///< samples since the start of which no message was made
    uint32_t n_in, n_out;  ///< that have entered and left the queue
    cam_strobe_sample_t queue[cam_strobe_capacity];
} cam_strobe_t;

/// @param tick_hz  [Hz]
/// @return         [ticks] least distance of two samples
uint32_t cam_strobe_least(uint32_t tick_hz);

/// Begin a subscription, or renew the one with the same distance.
/// @param every  [ticks] cam_strobe_least() .. tick rate; 0 ends it
/// @param tick   newest one; samples are of later ones
void cam_strobe_ask(cam_strobe_t *s, uint32_t every, uint32_t tick);

/// @return whether somebody asks
static inline bool cam_strobe_is_on(const cam_strobe_t *s)
{
    return s->every != 0u;
}

/// Take a record, in the order of the ticks.
void cam_strobe_take(cam_strobe_t *s, const cam_tick_record_t *r);

/// End a subscription that nobody has renewed.
/// @param tick  newest one
void cam_strobe_expire(cam_strobe_t *s, uint32_t tick, uint32_t tick_hz);

/// @return the oldest sample of the queue, NULL when there is none
const cam_strobe_sample_t *cam_strobe_oldest(const cam_strobe_t *s);

/// Take the oldest sample out of the queue.
void cam_strobe_drop(cam_strobe_t *s);

#endif
