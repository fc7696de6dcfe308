// SPDX-License-Identifier: Apache-2.0
/// sim_frame: a CAN frame and a queue of frames, for the simulated nodes.
///
/// Numbers are little-endian two's complement; common_bytes.h reads them.
#ifndef SIM_FRAME_H
#define SIM_FRAME_H

#include <stdint.h> // uint8_t, uint32_t

enum { sim_frame_max_bytes = 64, sim_frame_queue = 32 };

/// A classic (n <= 8) or FD frame with an 11-bit identifier.
typedef struct {
    uint32_t id;
    uint32_t n; ///< [bytes]
    uint8_t data[sim_frame_max_bytes];
} sim_frame_t;

/// Frames to send, the oldest first.
typedef struct {
    sim_frame_t frame[sim_frame_queue];
    uint32_t n;
} sim_frames_t;

/// Append a number of 1, 2 or 4 bytes.
static inline void sim_frame_put(sim_frame_t *f, uint32_t value, uint32_t n_bytes)
{
    for (uint32_t i = 0; i < n_bytes; i++) {
        f->data[f->n] = (uint8_t)(value >> (8u * i) & 0xFFu);
        f->n++;
    }
}

/// @return an empty frame at the end of the queue; the last one again when the queue is full
static inline sim_frame_t *sim_frames_add(sim_frames_t *q, uint32_t id)
{
    const uint32_t i = q->n < sim_frame_queue ? q->n++ : sim_frame_queue - 1u;
    q->frame[i] = (sim_frame_t){.id = id};
    return &q->frame[i];
}

#endif
