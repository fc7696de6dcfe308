// SPDX-License-Identifier: Apache-2.0
/// cam_can_inner: the topics of the commands over CAN, and what all of them use to answer.
///
/// cam_can.c takes the commands of table, parameters and states, and offers every other one to the
/// topics in turn. A topic is a file cam_can_TOPIC.c with one function of the name cam_can_TOPIC(),
/// which answers a command of its own and returns true, or returns false. Nobody outside of this
/// folder includes this header. Context: slow side, main() only.
#ifndef CAM_CAN_INNER_H
#define CAM_CAN_INNER_H

#include "cam_can.h" // cam_can_t
#include "cam_err.h" // cam_err_t
#include "camturn.h" // struct camturn_command_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint8_t, uint32_t

/// Result of a command with the value that its answer carries.
typedef struct {
    cam_err_t err;
    int32_t value;
} cam_outcome_t;

/// @return the outcome of a command whose answer carries no value
static inline cam_outcome_t cam_outcome(cam_err_t err)
{
    return (cam_outcome_t){.err = err};
}

/// Queue an answer, of which there is room for cam_can_max_answers.
void cam_can_answer(cam_can_t *r, uint8_t command, uint8_t parameter, cam_outcome_t outcome);

/// Begin a download of either kind.
/// @param size  [bytes]
cam_outcome_t cam_can_begin_download(cam_can_t *r, uint32_t size, bool is_wave);

/// @return an error with the number of bytes that have been stored
cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err);

/// Queue the smallest and the largest value of a parameter, behind the refusal of one beyond.
void cam_can_answer_range(cam_can_t *r, cam_param_id_t id);

/// Topic: all parameters at once, those that are kept, numbers of a refusal.
bool cam_can_params(cam_can_t *r, const struct camturn_command_t *m);

/// Set a parameter and answer with the value in force; a value out of its range gets
/// the range too.
void cam_can_set(cam_can_t *r, uint8_t command, cam_param_id_t id, int32_t value);

/// Topic: what is changed while a part is cut, and the number of parts.
bool cam_can_cut(cam_can_t *r, const struct camturn_command_t *m);

/// Topic: recorder, excitation and learning.
bool cam_can_scope(cam_can_t *r, const struct camturn_command_t *m);

/// Topic: samples of single ticks for a live picture.
bool cam_can_strobe(cam_can_t *r, const struct camturn_command_t *m);

/// Send a sample, at most cam_strobe_hz of them a second, fewer while a piece of a recording is
/// sent. One that finds no room is tried again; the queue behind it drops what has no place.
void cam_can_send_sample(cam_can_t *r, uint32_t tick);

/// @return cam_ok when its sender may give a command; else why not, with who may
cam_outcome_t cam_can_admit(const cam_can_t *r, const struct camturn_command_t *m);

/// A frame came, or what it asked for is done: if it is of the session in force, its commander was
/// heard.
void cam_can_hear(cam_can_t *r, const struct camturn_command_t *m);

/// Topic: who has command, and the level.
bool cam_can_rights(cam_can_t *r, const struct camturn_command_t *m);

/// @return whether the download that was begun last is of another session than the one in force
bool cam_can_is_foreign_download(const cam_can_t *r);

/// Topic: axes by hand, homes, datum and tools.
bool cam_can_jog(cam_can_t *r, const struct camturn_command_t *m);

/// Set a parameter by a command and answer with the value in force; a value out of its range gets
/// the range too.
void cam_can_set(cam_can_t *r, uint8_t command, cam_param_id_t id, int32_t value);

#endif
