// SPDX-License-Identifier: Apache-2.0
/// cam_trace: a ring of tick records, written by the interrupt, read by the slow side.
///
/// One writer, one reader, no lock: each owns one counter. A full ring drops the new record and
/// counts it, so what was read is always without gaps up to the first drop.
#ifndef CAM_TRACE_H
#define CAM_TRACE_H

#include "cam/cam_state.h" // cam_sense_t, cam_state_t
#include <stdatomic.h>     // the two counters
#include <stdbool.h>       // bool
#include <stdint.h>        // int32_t, int64_t

enum { cam_trace_capacity = 256 }; // a power of two: 12.8 ms at 20 kHz
_Static_assert((cam_trace_capacity & (cam_trace_capacity - 1)) == 0, "index by mask");

/// What one tick did: inputs and outputs complete, so that it can be replayed.
typedef struct {
    uint32_t tick;                  ///< ticks since start, wraps
    uint32_t config;                ///< generation of the configuration in force
    cam_sense_t in;                 ///< what it sensed
    int64_t pos_q32;                ///< [turn, Q32.32] master position (observer)
    int32_t speed_q32;              ///< [turn / 2^32 per tick]
    int32_t z_nm;                   ///< [nm] height that was played
    int32_t u_set_q6;               ///< [nm / 64] U wanted at the tool, before feed-forward
    int32_t u_due_q6;               ///< [nm / 64] U that the tool should have now
    hal_setpoint_t out[hal_n_axes]; ///< what was written to the axes
    int32_t spindle_mrpm;           ///< what was written to the spindle
    uint32_t outputs;               ///< hal_out_*
    uint32_t faults;                ///< latched faults
    cam_state_t state;              ///< after this tick
    bool is_synced;                 ///< angle known
    bool is_retracted;              ///< tool at rest out of the work
} cam_tick_record_t;

typedef struct {
    cam_tick_record_t ring[cam_trace_capacity];
    cam_tick_record_t spare[2]; ///< take in turns what is not kept
    uint32_t n_spared;          ///< interrupt only
    bool is_kept;               ///< interrupt only: this tick's record lies in the ring
    _Atomic uint32_t n_written; ///< interrupt writes
    _Atomic uint32_t n_read;    ///< slow side writes
    _Atomic uint32_t n_dropped; ///< interrupt writes
} cam_trace_t;

/// @param is_wanted  false: nobody reads the trace
/// @return where this tick's record is written: the next free place, or a spare one; never where
/// the last record lies. Context: ISR, constant time.
cam_tick_record_t *cam_trace_slot_isr(cam_trace_t *trace, bool is_wanted);

/// The record is complete: hand it to the reader. One that found no place was counted as dropped.
/// Context: ISR, constant time.
void cam_trace_commit_isr(cam_trace_t *trace);

/// Take the oldest record.
/// @return false when the ring is empty. Context: slow side.
bool cam_trace_pop(cam_trace_t *trace, cam_tick_record_t *record);

/// @return records lost since start because nobody read. Context: slow side.
uint32_t cam_trace_dropped(cam_trace_t *trace);

#endif
