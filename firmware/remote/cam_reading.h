// SPDX-License-Identifier: Apache-2.0
/// cam_reading: sends a piece of the recording (cam_scope.h) in numbered messages.
///
/// A piece is at most 255 words: 146 messages of 7 bytes; over CAN FD at most 4032 words: 256
/// messages of 63 bytes. Their rate is limited to leave room for the status, and a full transmit
/// queue only delays them. There is no state between pieces: any reader may request any piece, and
/// again if it was damaged. Context: slow side, main() only.
#ifndef CAM_READING_H
#define CAM_READING_H

#include "cam_err.h"   // cam_err_t
#include "cam_scope.h" // cam_scope_t
#include <stdbool.h>   // bool
#include <stdint.h>    // uint8_t, uint32_t

/// [Hz] highest rate of messages: with the status 60 % of a bus of 500 kbit/s, FD data at 2 Mbit/s.
enum { cam_reading_hz = 2500, cam_reading_fd_hz = 1600 };

/// An FD piece is a multiple of this many words, at most that many times.
enum { cam_reading_fd_grain = 16, cam_reading_fd_most = 252 };

/// State; zero-initialised sends nothing.
typedef struct {
    bool is_on;
    bool is_fd;          ///< messages of 64 bytes
    uint8_t parameter;   ///< of the command, to be echoed
    uint32_t number;     ///< of the recording: another one ends the piece
    uint32_t from;       ///< [bytes] begin of the piece in the recording
    uint32_t n_bytes;    ///< [bytes] of the piece
    uint32_t n_sent;     ///< [messages]
    uint32_t begin_tick; ///< when it began
} cam_reading_t;

/// Result of a poll.
typedef enum { cam_reading_nothing, cam_reading_complete, cam_reading_lost } cam_reading_event_t;

/// Begin a piece.
/// @param offset   [words] in the recording
/// @param n_words  wanted, at most those of a piece; fewer are sent where the recording ends
/// @param is_fd    in messages of CAN FD
/// @return         cam_ok; cam_err_scope_range: there is no such word; cam_err_scope_on: the
///                 recording has not ended
CAM_MUST_USE cam_err_t cam_reading_begin(cam_reading_t *r, const cam_scope_t *scope,
                                         uint32_t offset, uint32_t n_words, bool is_fd,
                                         uint32_t tick);

/// Send the messages that are due and fit the transmit queue.
/// @return complete: the last message was queued; lost: another recording has begun meanwhile
cam_reading_event_t cam_reading_poll(cam_reading_t *r, const cam_scope_t *scope, uint32_t tick);

/// @return CRC-32 of the bytes of the piece
uint32_t cam_reading_crc(const cam_reading_t *r, const cam_scope_t *scope);

#endif
