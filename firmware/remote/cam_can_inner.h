// SPDX-License-Identifier: Apache-2.0
/// cam_can_inner: groups of CAN commands, private to this room.
///
/// cam_can.c handles tables, single parameters and states and offers every other command to the
/// groups in turn. cam_can_GROUP() in cam_can_GROUP.c answers a command of its own and returns
/// true; otherwise it returns false. Context: slow side, main() only.
#ifndef CAM_CAN_INNER_H
#define CAM_CAN_INNER_H

#include "cam_can.h" // cam_can_t
#include "cam_err.h" // cam_err_t
#include "camturn.h" // struct camturn_command_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint8_t, uint32_t

/// Result of a command and the value of its answer.
typedef struct {
    cam_err_t err;
    int32_t value;
} cam_outcome_t;

/// @return an outcome without a value
static inline cam_outcome_t cam_outcome(cam_err_t err)
{
    return (cam_outcome_t){.err = err};
}

/// Queue an answer, of which there is room for cam_can_max_answers.
void cam_can_answer(cam_can_t *r, uint8_t command, uint8_t parameter, cam_outcome_t outcome);

/// Begin a download of either kind.
/// @param size  [bytes]
cam_outcome_t cam_can_begin_download(cam_can_t *r, uint32_t size, bool is_wave);

/// @return an error with the number of bytes stored
cam_outcome_t cam_can_received(const cam_can_t *r, cam_err_t err);

/// Queue the smallest and the largest value of a parameter, after the refusal of another.
void cam_can_answer_range(cam_can_t *r, cam_param_id_t id);

/// Group: staged and stored parameters, fields of a refusal.
bool cam_can_params(cam_can_t *r, const struct camturn_command_t *m);

/// Group: changes while a part is cut, and the number of parts.
bool cam_can_cut(cam_can_t *r, const struct camturn_command_t *m);

/// Group: recorder, excitation and learning.
bool cam_can_scope(cam_can_t *r, const struct camturn_command_t *m);

/// Group: samples of single ticks for a live picture.
bool cam_can_strobe(cam_can_t *r, const struct camturn_command_t *m);

/// Send a sample, at most cam_strobe_hz a second, fewer while a piece of a recording is sent. One
/// that does not fit is tried again; meanwhile the queue of samples may overflow and drop some.
void cam_can_send_sample(cam_can_t *r, uint32_t tick);

/// @return cam_ok if the sender may give the command; else the error, with the commander's number
cam_outcome_t cam_can_admit(const cam_can_t *r, const struct camturn_command_t *m);

/// Note the commander as heard if a command is of the current session.
void cam_can_hear(cam_can_t *r, const struct camturn_command_t *m);

/// Group: command and level.
bool cam_can_rights(cam_can_t *r, const struct camturn_command_t *m);

/// @return whether the last download was begun by another session than the current one
bool cam_can_is_foreign_download(const cam_can_t *r);

/// Group: jogging, homing, datum and tools.
bool cam_can_jog(cam_can_t *r, const struct camturn_command_t *m);

/// Set a parameter and answer with the value in force; a value out of its range also gets the
/// range.
void cam_can_set(cam_can_t *r, uint8_t command, cam_param_id_t id, int32_t value);

#endif
