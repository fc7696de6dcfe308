// SPDX-License-Identifier: Apache-2.0
/// cam_isotp: receives messages of more than a frame: ISO 15765-2, classic frames, normal
/// addressing, one connection.
///
///     single frame       0n  n bytes, 1 .. 7
///     first frame        1x xx  length 8 .. 4095, six bytes   or   10 00 length in four bytes,
///                        the highest first, two bytes
///     flow control       30 block size, separation time       or   32: the message is too long
///     consecutive frame  2s  up to seven bytes; s counts 1, 2, .. 15, 0, ..
///
/// A consecutive frame out of order or late (N_Cr) ends the message; a single or first frame begins
/// a new one whatever was on its way; all else that does not fit is passed over, as the standard
/// wants. Context: slow side.
#ifndef CAM_ISOTP_H
#define CAM_ISOTP_H

#include "hal/hal.h" // hal_can_frame_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

/// Consecutive frames between two flow controls: half of what the smallest port queues.
enum { cam_isotp_block_size = 8 };

typedef enum {
    cam_isotp_nothing,
    cam_isotp_message, ///< bytes[0 .. length - 1] is complete
    cam_isotp_broken,  ///< the message on its way is lost
} cam_isotp_event_t;

/// State; the first three are set by the owner, all else zero.
typedef struct {
    uint8_t *bytes;
    uint32_t capacity; ///< [bytes]
    uint32_t patience; ///< N_Cr, in the unit of `now`
    uint32_t length;   ///< [bytes] of the message
    uint32_t n;        ///< [bytes] of it that are there
    uint32_t next;     ///< sequence number of the next consecutive frame
    uint32_t n_block;  ///< consecutive frames until the next flow control
    uint32_t since;    ///< when the last frame came
    bool is_receiving;
    bool has_flow; ///< flow control waits to be sent
    bool is_too_long;
} cam_isotp_t;

/// Take a frame of the connection.
/// @param now  time, wraps
cam_isotp_event_t cam_isotp_receive(cam_isotp_t *t, const hal_can_frame_t *frame, uint32_t now);

/// Let time pass. @return cam_isotp_broken when the next frame is overdue
cam_isotp_event_t cam_isotp_wait(cam_isotp_t *t, uint32_t now);

/// @param frame  filled but for its id
/// @return       whether a flow control is to be sent; tell by cam_isotp_flow_sent()
bool cam_isotp_flow(const cam_isotp_t *t, hal_can_frame_t *frame);
void cam_isotp_flow_sent(cam_isotp_t *t);

#endif
