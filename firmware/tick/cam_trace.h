// SPDX-License-Identifier: Apache-2.0
/// cam_trace: the records of the last ticks, written by the interrupt, read by the slow side.
///
/// A ring without a lock: the record of tick n is ring[n % cam_trace_capacity]. The interrupt never
/// waits for a reader and does not know of it. A reader copies a record, then checks that it was
/// not overwritten meanwhile; it counts the ticks that it has missed.
#ifndef CAM_TRACE_H
#define CAM_TRACE_H

#include "cam_record.h" // cam_tick_record_t
#include <stdatomic.h>  // the counters
#include <stdbool.h>    // bool
#include <stddef.h>     // size_t
#include <stdint.h>     // uint32_t

enum { cam_trace_capacity = 256 }; // a power of two: 12.8 ms at 20 kHz
_Static_assert((cam_trace_capacity & (cam_trace_capacity - 1)) == 0, "index by mask");

/// Zero-initialised: no tick has begun.
typedef struct {
    cam_tick_record_t *_Atomic newest; ///< interrupt writes: of the newest complete tick
    _Atomic uint32_t n_begun;          ///< interrupt writes: ticks that have begun; wraps
    _Atomic uint32_t n_written;        ///< interrupt writes: complete ticks; wraps
    uint32_t n_read;                   ///< slow side only: ticks taken or missed
    uint32_t n_missed;                 ///< slow side only: ... of these the missed ones
    cam_tick_record_t ring[cam_trace_capacity];
} cam_trace_t;

/// Begin a tick. A reader that sees anything this tick writes also sees that the tick has begun.
/// @return its record with its number, unchanged for 255 ticks after it. Context: ISR, constant
/// time.
cam_tick_record_t *cam_trace_begin_isr(cam_trace_t *trace);

/// Hand the complete record to the readers, after a release fence. Context: ISR, constant time.
void cam_trace_commit_isr(cam_trace_t *trace, cam_tick_record_t *record);

/// @return the record of the newest complete tick; before the first one, of a tick in state off.
///         Context: slow side
static inline const cam_tick_record_t *cam_trace_newest(const cam_trace_t *trace)
{
    const cam_tick_record_t *newest = atomic_load_explicit(&trace->newest, memory_order_acquire);
    return newest != NULL ? newest : &trace->ring[0];
}

/// Take the oldest record that was not taken yet and is still in the ring.
/// @return false if all have been taken. Context: slow side, one caller.
bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record);

/// Copy words that the interrupt may be writing; such a copy is discarded. Context: slow side.
void cam_trace_copy(void *to, const void *from, size_t n_bytes);

#endif
