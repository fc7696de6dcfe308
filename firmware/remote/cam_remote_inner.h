// SPDX-License-Identifier: Apache-2.0
/// cam_remote_inner: the parts of the remote control, private to this room.
///
/// A frame comes in through ISO-TP or as a command; commands act on the machine and the table
/// store; recordings, status and lines of text go out. Read the parts in this order. Context of all
/// functions: slow side, main() only.
#ifndef CAM_REMOTE_INNER_H
#define CAM_REMOTE_INNER_H

#include "cam_err.h"      // cam_err_t, CAM_MUST_USE
#include "cam_machine.h"  // cam_machine_t
#include "cam_recorder.h" // cam_scope_t
#include "cam_remote.h"   // cam_can_t, cam_isotp_t, cam_table_store_t
#include "cam_tick.h"     // cam_status_t
#include "hal/hal.h"      // hal_can_frame_t, hal_start_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int32_t, uint8_t, uint32_t

struct camturn_command_t; // camturn.h

/// ISO-TP: receives messages of more than one frame: ISO 15765-2 with classic frames, normal
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
/// ignored, as the standard demands.

/// Consecutive frames between two flow controls: half of what the smallest port queues.
enum { cam_isotp_block_size = 8 };

/// Event caused by a frame or a timeout.
typedef enum {
    cam_isotp_nothing, ///< the message is not complete, or the frame was ignored
    cam_isotp_message, ///< bytes[0 .. length - 1] is complete
    cam_isotp_broken,  ///< the message that was being received is lost
} cam_isotp_event_t;

/// Take a frame of the connection.
/// @param tick  [ticks] time, wraps
/// @return      cam_isotp_message when it completes a message, cam_isotp_broken when it ends one
cam_isotp_event_t cam_isotp_receive(cam_isotp_t *t, const hal_can_frame_t *frame, uint32_t tick);

/// @return cam_isotp_broken when the next frame is overdue
cam_isotp_event_t cam_isotp_wait(cam_isotp_t *t, uint32_t tick);

/// @return whether a flow control, all but its id, is to be sent; clear has_flow then
bool cam_isotp_flow(const cam_isotp_t *t, hal_can_frame_t *frame);

/// Commands: whether a sender may give them, what they do, and their answers.

/// Result of a command and the value of its answer.
typedef struct {
    cam_err_t err;
    int32_t value;
    bool is_deferred; ///< the answer follows the piece of a recording
    bool has_range;   ///< two more answers give the smallest and the largest value
    int32_t min, max;
} cam_outcome_t;

static inline cam_outcome_t cam_outcome(cam_err_t err)
{
    return (cam_outcome_t){.err = err};
}

/// @return whether the sender of a command may give it: cam_ok, cam_err_not_commander,
///         cam_err_locked or cam_err_lock_none
cam_err_t cam_can_admit(const cam_rights_t *rights, const struct camturn_command_t *m);

cam_outcome_t cam_can_carry_out(cam_can_t *r, const struct camturn_command_t *m);

/// @return err with the number of bytes stored
cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err);

/// Select the table and report it in a line of text, unless the error is temporary.
cam_err_t cam_can_select(cam_can_t *r);

/// The two slots for tables: one is in use, the other takes a download.
///
///     begin(size) -> block, block, .. -> end(crc) -> select
///
/// Only select replaces the table in use, and only by a download that is complete (CRC-32) and
/// passed cam_table_check(). Any error before, or a new begin, leaves the old table in
/// force. All steps need the state off or ready, in which no tick reads a table; in ready the new
/// table must also turn in the same sense and be feasible.

/// @return the little-endian word at some bytes, such as the offset of a block
static inline uint32_t cam_table_store_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/// Put a table into use: a complete download, else the table of the slot in use, checked again.
/// @return as cam_machine_select_table(); cam_err_no_table if the slot is empty;
///         cam_err_download_store if the port could not store the download: the old table stays in
///         force, and every further select tries again until a new download begins
/// Context: lasts as long as cam_table_check() and, after a download, hal_table_commit().
CAM_MUST_USE cam_err_t cam_table_store_select(cam_table_store_t *s);

/// @return whether an error of cam_table_store_select() is temporary (state, busy, store), not the
///         result of the table's check
bool cam_table_store_is_of_moment(cam_err_t err);

/// Begin a download: empty the other place. What was downloaded before is lost.
/// @param size  [bytes] of the image
/// @return cam_ok, cam_err_state, cam_err_busy, cam_err_image_size (less than a header),
///         cam_err_download_room (larger than the place, or the place cannot be emptied)
/// Context: lasts as long as hal_table_begin().
CAM_MUST_USE cam_err_t cam_table_store_begin(cam_table_store_t *s, uint32_t size);

/// Store the next block. A block that is stored already is accepted without being written again.
/// @param block  n bytes: the offset, then bytes of the image; every block but the last holds a
///               multiple of hal_table_grain
/// @return cam_ok; cam_err_state, cam_err_busy; cam_err_download_order: nothing has changed, and
///         `received` is the offset of the block that is due; cam_err_download_room: beyond the
///         announced size; cam_err_download_store: the download has to begin anew
/// Context: lasts as long as hal_table_write().
CAM_MUST_USE cam_err_t cam_table_store_block(cam_table_store_t *s, const uint8_t *block,
                                             uint32_t n);

/// End a download: check what has been stored.
/// @param crc  CRC-32 of all bytes of the image, as sent
/// @return cam_ok: the next select takes the table; cam_err_state, _busy, cam_err_download_order,
///         _short: the download may go on; cam_err_download_crc or an error of
///         cam_table_check(): the download has to begin anew
/// Context: lasts as long as cam_table_check().
CAM_MUST_USE cam_err_t cam_table_store_end(cam_table_store_t *s, uint32_t crc);

/// Reading: sends a piece of the recording in numbered messages. A piece is at most 255 words: 146
/// messages of 7 bytes; over CAN FD at most 4032 words: 256 messages of 63 bytes. Their rate is
/// limited to leave room for the status, and a full transmit queue only delays them. There is no
/// state between pieces: any reader may request any piece, and again if it was damaged.

/// [Hz] highest rate of messages: with the status 60 % of a bus of 500 kbit/s, FD data at 2 Mbit/s.
enum { cam_reading_hz = 2500, cam_reading_fd_hz = 1600 };

/// Result of a poll.
typedef enum { cam_reading_nothing, cam_reading_complete, cam_reading_lost } cam_reading_event_t;

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

/// @return CRC-32 of the piece
uint32_t cam_reading_crc(const cam_reading_t *r, const cam_scope_t *scope);

/// Report: the cyclic status, messages State, Spindle, AxisU and Detail of can/camturn.dbc. Sent
/// every 10 ms, counted in ticks, so without ticks there is no status. Of Detail, page 0 is sent
/// each time, and the other pages in turn. A frame that does not fit the transmit queue is dropped.

void cam_report_send(cam_report_t *r, const cam_table_store_t *store, const cam_status_t *status);

/// Lines of text for people, written by hal_text().

/// For example "start: watchdog reset".
void cam_log_text_start(const hal_start_t *start);

/// Report the initial parameters, for example "params: version 12 in use", and the stored ones that
/// this image does not use.
void cam_log_text_params(const cam_machine_t *machine);

/// Report resolution and highest speed of the axes that the port names, and the resulting form
/// error of the table in use: "scales: U 30.5 nm, read to 100.0 nm; X 50.0 nm up to 36000 um/s" and
/// "form error by the steps of the outputs: 0.040 um; a count of the encoder is 94.2 nm of U".
void cam_log_text_scales(const cam_machine_t *machine);

/// Report the result of the last check of the table, for example "table: perkins240 in use". A
/// second line names a speed at which the encoder's counts do not average, and a better one.
void cam_log_text_table(cam_log_text_t *l, const cam_table_store_t *store);

/// Report a command that its sender may not give, at most once a second.
void cam_log_text_refused(cam_log_text_t *l, uint32_t sender, uint32_t command, cam_err_t err,
                          uint32_t tick);

/// Report at most one change of table, state, fault, commander or level, or the end of a start
/// without a steady spindle, so that a slow serial line does not hold up the main loop. If the
/// background check found the table damaged, this also sets the store's error.
void cam_log_text_change(cam_log_text_t *l, cam_table_store_t *store, const cam_status_t *status);

#endif
