// SPDX-License-Identifier: Apache-2.0
/// cam_isotp: receives messages of more than one frame: ISO 15765-2 with classic frames, normal
/// addressing, one connection.
///
///     single frame       0n  n bytes, 1 .. 7
///     first frame        1x xx  length 8 .. 4095, six bytes   or   10 00 length in four bytes,
///                        the highest first, two bytes
///     flow control       30 block size, separation time       or   32: the message is too long
///     consecutive frame  2s  up to seven bytes; s counts 1, 2, .. 15, 0, ..
///
/// A consecutive frame that is out of order or late (N_Cr) ends the message. A single or first
/// frame begins a new message even while another is being received. Other unexpected frames are
/// ignored, as the standard demands. Context of all functions: slow side.
#ifndef CAM_ISOTP_H
#define CAM_ISOTP_H

#include "hal/hal.h" // hal_can_frame_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint32_t

/// Consecutive frames between two flow controls: half of what the smallest port queues.
enum { cam_isotp_block_size = 8 };

/// Event caused by a frame or a timeout.
typedef enum {
    cam_isotp_nothing, ///< the message is not complete, or the frame was ignored
    cam_isotp_message, ///< bytes[0 .. length - 1] is complete
    cam_isotp_broken,  ///< the message that was being received is lost
} cam_isotp_event_t;

/// State. The owner sets bytes, capacity and timeout_ticks; all other members begin as zero.
typedef struct {
    uint8_t *bytes;         ///< buffer of the message
    uint32_t capacity;      ///< [bytes] of the buffer
    uint32_t timeout_ticks; ///< [ticks] N_Cr: longest wait for a consecutive frame
    uint32_t length;        ///< [bytes] of the message
    uint32_t n;             ///< [bytes] of it that have been received
    uint32_t next;          ///< sequence number of the next consecutive frame
    uint32_t n_block;       ///< consecutive frames until the next flow control
    uint32_t last_tick;     ///< [ticks] when the last frame came
    bool is_receiving;      ///< a long message has begun and is not complete
    bool has_flow;          ///< a flow control waits to be sent
    bool is_too_long;       ///< that flow control reports a message beyond the capacity
} cam_isotp_t;

/// Take a frame of the connection.
/// @param tick  [ticks] time, wraps
/// @return      cam_isotp_message when it completes a message, cam_isotp_broken when it ends one
cam_isotp_event_t cam_isotp_receive(cam_isotp_t *t, const hal_can_frame_t *frame, uint32_t tick);

/// Check the timeout when no frame has come.
/// @param tick  [ticks] time, wraps
/// @return      cam_isotp_broken when the next frame is overdue
cam_isotp_event_t cam_isotp_wait(cam_isotp_t *t, uint32_t tick);

/// @param frame  result: the flow control to be sent, all but its id
/// @return       whether there is one; after sending it call cam_isotp_flow_sent()
bool cam_isotp_flow(const cam_isotp_t *t, hal_can_frame_t *frame);

/// Note that the flow control has been sent.
void cam_isotp_flow_sent(cam_isotp_t *t);

#endif
