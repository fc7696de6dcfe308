// SPDX-License-Identifier: Apache-2.0
/// cam_trace: a ring of tick records, written by the interrupt, read by the slow side.
///
/// One writer, one reader, no lock: each owns a counter. A full ring drops new records, counted.
#ifndef CAM_TRACE_H
#define CAM_TRACE_H

#include "cam_record.h" // cam_tick_record_t
#include <stdatomic.h>  // the counters
#include <stdbool.h>    // bool
#include <stdint.h>     // uint32_t

enum { cam_trace_capacity = 256 }; // a power of two: 12.8 ms at 20 kHz
_Static_assert((cam_trace_capacity & (cam_trace_capacity - 1)) == 0, "index by mask");

typedef struct {
    uint32_t n_spared;          ///< interrupt only
    uint32_t n_next;            ///< interrupt only: n_written after this tick
    _Atomic uint32_t n_written; ///< interrupt writes
    _Atomic uint32_t n_read;    ///< slow side writes
    _Atomic uint32_t n_dropped; ///< interrupt writes: records lost because the ring was full
    cam_tick_record_t spare[2]; ///< alternately hold the records that are not kept
    cam_tick_record_t ring[cam_trace_capacity];
} cam_trace_t;

/// @param room  [records] that may wait in the ring: cam_trace_capacity, or 0 for no trace
/// @return record to be written by this tick: the next free one or a spare one, never that of the
/// last tick. Context: ISR, constant time.
cam_tick_record_t *cam_trace_slot_isr(cam_trace_t *trace, uint32_t room);

/// Hand the complete record to the reader, after a release fence. Context: ISR, constant time.
void cam_trace_commit_isr(cam_trace_t *trace);

/// Take the oldest record.
/// @return false when the ring is empty. Context: slow side.
bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record);

#endif
