// SPDX-License-Identifier: Apache-2.0
/// sim_emulator: a Cortex-M in a process of its own, and two pipes to the program on it.
///
/// The program opens the pipes by number (pil_wire.h), so no file is needed, and whichever side
/// ends first, the other one sees the end of a pipe. Both run on one CPU: the hand-over is then a
/// switch of processes instead of the waking of another CPU, which is seven times as fast. There is
/// one emulator at a time.
#ifndef SIM_EMULATOR_H
#define SIM_EMULATOR_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

typedef struct {
    int pid;
    int request_fd; ///< towards the target
    int answer_fd;  ///< from it
    int spare_fd;   ///< the reading end of requests: held, so that writing never raises SIGPIPE
    int words_fd;   ///< memory with the output of the emulator, for the message when it ends
} sim_emulator_t;

/// @param board  as the emulator calls it
/// @param image  path of the program
/// @return       false and *e when there is no emulator; nothing to stop then
bool sim_emulator_start(sim_emulator_t *m, const char *board, const char *image, common_error_t *e);

/// @param n  [bytes] at most 4096: never blocks, because a request follows an answer
bool sim_emulator_send(sim_emulator_t *m, const void *bytes, size_t n, common_error_t *e);

/// Wait for exactly n bytes. @return false and *e when the emulator has ended or keeps silent
bool sim_emulator_receive(sim_emulator_t *m, void *bytes, size_t n, common_error_t *e);

void sim_emulator_stop(sim_emulator_t *m);

#endif
