// SPDX-License-Identifier: Apache-2.0
/// fixture_can: the ideal machine of fixture_rig started as a stand-alone image: its table lies
/// in a flash sector, commands and status go over the CAN queues of hal/host.
#ifndef FIXTURE_CAN_H
#define FIXTURE_CAN_H

#include "cam/cam_can.h" // cam_can_t
#include "fixture_rig.h" // fixture_rig_t
#include <stdint.h>      // int32_t

typedef struct {
    fixture_rig_t rig; ///< .image is the sector, erased behind the table
    cam_can_t can;
} fixture_can_t;

/// An answer, taken apart.
typedef struct {
    uint32_t command, index;
    int32_t result, value;
} fixture_answer_t;

/// Reset everything, write a good table into the sector. The image is not started.
void fixture_can_init(fixture_can_t *f, const fixture_part_t *part, uint32_t tick_hz);

/// What main() does before its loop, and the first tick.
void fixture_can_start(fixture_can_t *f);

/// What main() does in its loop, n times.
void fixture_can_loop(fixture_can_t *f, uint32_t n);

/// A frame for the controller arrives. Bytes 2 and 3 are zero.
void fixture_can_receive(uint32_t id, uint32_t n, uint8_t command, uint8_t index, int32_t value);

/// Send a command and poll once. @return the answer, which must be the only one, then a tick
fixture_answer_t fixture_can_command(fixture_can_t *f, uint8_t command, uint8_t index,
                                     int32_t value);

/// @return state of the controller after the last tick
cam_state_t fixture_can_state(const fixture_can_t *f);

/// @return frame sent last with an id; .id is 0 when there is none among those that the port keeps
hal_can_frame_t fixture_can_sent(uint32_t id);

/// @return frame with id 0x4C0 and a page sent last, .id 0 when none is kept
hal_can_frame_t fixture_can_detail(uint8_t page);

/// @return a frame of id 0x5C0, taken apart
fixture_answer_t fixture_can_answer(const hal_can_frame_t *frame);

/// @return little-endian number in a frame
int32_t fixture_can_i16(const hal_can_frame_t *frame, uint32_t at);
int32_t fixture_can_i32(const hal_can_frame_t *frame, uint32_t at);

/// @return a line for people, 0: the newest
const char *fixture_can_line(uint32_t n_ago);

#endif
