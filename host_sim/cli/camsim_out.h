// SPDX-License-Identifier: Apache-2.0
/// camsim_out: output files that appear complete or not at all.
///
/// Everything goes to a temporary file beside the target; when all of it is on the disk, the file
/// takes its final name. Interrupted or failed runs leave nothing behind. A target that is no
/// regular file (a pipe, /dev/stdout) is written directly.
#ifndef CAMSIM_OUT_H
#define CAMSIM_OUT_H

#include "sim_error.h" // sim_error_t
#include <stdbool.h>   // bool
#include <stdint.h>    // int64_t
#include <stdio.h>     // FILE

enum { camsim_out_path = 4096, camsim_out_buffer = 1 << 16 };

typedef struct {
    const char *name;            ///< as the user gave it; NULL: not wanted, all calls do nothing
    char final[camsim_out_path]; ///< links resolved
    char temporary[camsim_out_path + 16]; ///< "" when written directly
    FILE *stream;
    int error; ///< errno of the first failure, 0
    size_t n;
    char buffer[camsim_out_buffer];
} camsim_out_t;

/// Catch SIGINT, SIGTERM, SIGHUP and SIGPIPE: remove the temporaries, then die of the signal.
void camsim_out_watch_signals(void);

/// @param name    of the target, NULL: not wanted
/// @param option  for the message
/// @return        false and *e when it cannot be written
bool camsim_out_open(camsim_out_t *o, const char *name, const char *option, sim_error_t *e);

/// Bring everything to the disk and close. @return false and *e on any failure
bool camsim_out_finish(camsim_out_t *o, sim_error_t *e);

/// Give the finished file its name. @return false and *e on failure
bool camsim_out_publish(camsim_out_t *o, sim_error_t *e);

/// Remove what is not published.
void camsim_out_drop(camsim_out_t *o);

// Text; a failure is kept until finish.

void camsim_out_text(camsim_out_t *o, const char *text);
void camsim_out_char(camsim_out_t *o, char c);
void camsim_out_integer(camsim_out_t *o, int64_t value);

/// value * 10^-decimals with all its decimals.
void camsim_out_decimal(camsim_out_t *o, int64_t value, int decimals);

/// value rounded to decimals; |value| * 10^decimals < 2^62
void camsim_out_real(camsim_out_t *o, double value, int decimals);

#endif
