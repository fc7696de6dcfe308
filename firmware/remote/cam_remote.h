// SPDX-License-Identifier: Apache-2.0
/// cam_remote: remote control of a stand-alone controller: commands, status and downloads over CAN,
/// and lines of text for people.
///
/// can/camturn.dbc defines the messages, cantools generates their pack and unpack functions from
/// it, and can/README.md describes the protocol. In addition:
///
/// - Every command frame is answered: with cam_err_frame if its length is not 8 (missing bytes are
///   echoed as 0), with cam_err_not_commander if the command needs the right to command and its
///   sender does not have it, with cam_err_command if it is unknown. Frames with other ids are
///   ignored.
/// - read_scope alone is answered later, when its data has been sent. A block, or any command but
///   heartbeat, aborts it unanswered.
/// - Answers that do not fit the transmit queue are kept, and nothing is read until they are sent.
/// - A silent bus also stops the commander's heartbeats: a second later the cut ends as by stop.
/// - A table that fails its check does not keep the controller from starting. Until one is
///   selected, enable is refused with the error of the check, which the status and a text report.
///
/// A program needs the two functions at the end; before them stand the states of the parts, whose
/// manuals are in cam_remote_inner.h. All functions: slow side, main() only.
#ifndef CAM_REMOTE_H
#define CAM_REMOTE_H

#include "cam_err.h"     // cam_err_t
#include "cam_machine.h" // cam_machine_t
#include "hal/hal.h"     // hal_can_frame_t, hal_start_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint8_t, uint32_t, uint64_t

/// Blocks of a download.
enum {
    cam_table_store_block_header = 4,   ///< [bytes] offset of a block, the lowest byte first
    cam_table_store_block_bytes = 4096, ///< [bytes] of the image in a block, at most
};

/// State of the two slots for tables. Zero-initialised except for machine and err, which begins as
/// cam_err_no_table.
typedef struct {
    cam_machine_t *machine; ///< initialised
    cam_err_t err;          ///< result of the last check of the table in use
    uint32_t generation;    ///< how often a table has been taken into use
    uint32_t size;          ///< [bytes] of the image that is being downloaded
    uint32_t received;      ///< [bytes] of it that have been stored
    bool is_open;           ///< a download has begun, blocks are accepted
    bool is_checked;        ///< the download is complete and good: the next select takes it
} cam_table_store_t;

/// State of the status messages. Zero-initialised except for start.
typedef struct {
    hal_start_t start;    ///< why the controller started
    uint32_t status_tick; ///< [ticks] when the last status was due
    uint32_t i_page;      ///< last page of Detail that was sent in turn
    uint64_t load_cycles; ///< of the interrupts sampled since page 24 was sent
    uint32_t n_loads;     ///< how many were sampled
} cam_report_t;

/// The values that lines of text reported last; starts with zeros.
typedef struct {
    bool has_table;    ///< a table was in use in the last line about it
    cam_state_t state; ///< state of the last line about a state
    bool is_unsteady;  ///< the end of a start without a steady spindle was reported
    uint32_t faults;   ///< mask of the reported faults that are still latched
    bool has_loop;     ///< the loop of U was reported as not measured since the drives were off
    bool has_distance; ///< the counts between two index edges were reported in this fault
    uint32_t commander, n_take_overs, n_losses; ///< of the last line about command
    cam_level_t level;                          ///< of the last line about it
    uint32_t n_refused;     ///< commands refused for lack of rights, not all of them reported
    uint32_t refused_tick;  ///< [ticks] of the last line about one
    uint32_t refused_ticks; ///< [ticks] least time between two of these lines
} cam_log_text_t;

/// State of the receiver of long messages. The owner sets bytes, capacity and timeout_ticks; all
/// other members begin as zero.
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

/// State of the sender of a recording. Zero-initialised sends nothing.
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

enum { cam_can_max_answers = 3 }; ///< to a value out of its range: refusal, minimum, maximum

/// State; made by cam_can_init().
typedef struct {
    cam_machine_t *machine;
    cam_table_store_t store;
    cam_report_t report;
    cam_log_text_t lines;
    cam_isotp_t isotp;
    uint8_t block[cam_table_store_block_header +
                  cam_table_store_block_bytes];   ///< message being received
    hal_can_frame_t answers[cam_can_max_answers]; ///< to the last command
    uint32_t n_answers, n_answered;               ///< queued, and sent of these
    bool is_wave;                                 ///< blocks are of a wave, not of a table
    uint8_t download_session;                     ///< that began the last download, of either kind
    cam_reading_t reading;                        ///< piece of the recording that is being sent
} cam_can_t;

/// Put the table of hal_table_image() into use if it is good, and report start and table as text.
/// @param machine  initialised, in state off; kept and used by cam_can_poll()
/// Context: main(), before hal_tick_start(); lasts as long as cam_table_store_select().
void cam_can_init(cam_can_t *r, cam_machine_t *machine);

/// Execute at most one command or store at most one block, send the status when due, and report at
/// most one change as a line of text.
/// Context: main loop. A command may last as long as the check of a whole table or its download,
/// for which a watchdog must allow.
void cam_can_poll(cam_can_t *r);

#endif
