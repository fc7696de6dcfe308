// SPDX-License-Identifier: Apache-2.0
/// sim_emulator: a Cortex-M in its own process, with two pipes to its program.
///
/// The program opens the pipes by number (pil_wire.h), so no file is needed; when one side ends,
/// the other reads the end of a pipe. Both run on one CPU: a hand-over is then a process switch
/// instead of a wake-up of another CPU, seven times as fast. Only one emulator runs at a time.
#ifndef SIM_EMULATOR_H
#define SIM_EMULATOR_H

#include "common_error.h" // common_error_t
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

typedef struct {
    int pid;
    int request_fd; ///< to the target
    int answer_fd;  ///< from the target
    int spare_fd;   ///< read end of requests, kept open so that writing never raises SIGPIPE
    int words_fd;   ///< memory file with the emulator's output, for error messages
} sim_emulator_t;

/// @param board  name of the board in the emulator
/// @param image  path of the program
/// @return       false and *e when the emulator does not start; then nothing to stop
bool sim_emulator_start(sim_emulator_t *m, const char *board, const char *image, common_error_t *e);

/// @param n  [bytes] at most 4096: never blocks, because a request follows an answer
bool sim_emulator_send(sim_emulator_t *m, const void *bytes, size_t n, common_error_t *e);

/// Wait for exactly n bytes. @return false and *e when the emulator has ended or does not answer
bool sim_emulator_receive(sim_emulator_t *m, void *bytes, size_t n, common_error_t *e);

void sim_emulator_stop(sim_emulator_t *m);

#endif
