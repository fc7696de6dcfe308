// SPDX-License-Identifier: Apache-2.0
/// expect_can: what the tests of the CAN messages demand of commands, tables and downloads. Each
/// fails the running test of Unity unless it is so.
#ifndef EXPECT_CAN_H
#define EXPECT_CAN_H

#include "fixture_download.h" // fixture_can_t, fixture_download_t

/// Send a command: its answer has this result and this value.
void expect_answer(fixture_can_t *f, cam_err_t result, int32_t value, uint8_t command,
                   uint8_t index, int32_t sent);

/// Send a block of the other table: the answer has this result and tells `received` bytes.
void expect_block(fixture_download_t *d, cam_err_t err, uint32_t offset, uint32_t n,
                  uint32_t received);

/// Send the blocks from .. to - 1 of the other table: each is taken.
void expect_blocks(fixture_download_t *d, uint32_t from, uint32_t to);

/// Begin a download of the other table: it is accepted.
void expect_begin(fixture_download_t *d);

/// The table of the start is in force, now, when selected and after a restart.
void expect_old_in_force(fixture_download_t *d);

#endif
