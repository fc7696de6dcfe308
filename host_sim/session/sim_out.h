// SPDX-License-Identifier: Apache-2.0
/// sim_out: output files that appear complete or not at all, and the text in them; or the same
/// columns as numbers in memory.
///
/// The output goes to a temporary file beside the target; when all of it is on the disk, the file
/// takes its final name. Interrupted and failed runs leave nothing behind. A target that is no
/// regular file (a pipe, /dev/stdout) is written directly.
#ifndef SIM_OUT_H
#define SIM_OUT_H

#include "common_error.h" // common_error_t
#include "sim_values.h"   // sim_values_t
#include <stdbool.h>      // bool
#include <stdint.h>       // int64_t
#include <stdio.h>        // FILE

enum { sim_out_path = 4096, sim_out_buffer = 1 << 16 };

typedef struct {
    const char *name;         ///< as the user gave it; NULL: not wanted, all calls do nothing
    char final[sim_out_path]; ///< links resolved
    char temporary[sim_out_path + 16]; ///< "" when written directly
    sim_values_t *values;              ///< NULL: text in a file
    FILE *stream;
    int error; ///< errno of the first failure, 0
    size_t n;
    char buffer[sim_out_buffer];
} sim_out_t;

/// Catch SIGINT, SIGTERM, SIGHUP and SIGPIPE: remove the temporaries, then die of the signal.
void sim_out_watch_signals(void);

/// @param name    of the target, NULL: not wanted
/// @param option  for the message
/// @return        false and *e when it cannot be written
bool sim_out_open(sim_out_t *o, const char *name, const char *option, common_error_t *e);

/// Take the columns as numbers in memory; finishing, publishing and dropping then do nothing.
/// @param name  of the output, for messages
void sim_out_open_values(sim_out_t *o, const char *name, sim_values_t *values);

/// Write text into a stream, which is closed by finishing or dropping.
/// @param name  of the output, for messages
void sim_out_open_stream(sim_out_t *o, const char *name, FILE *stream);

/// Bring everything to the disk and close. @return false and *e on any failure
bool sim_out_finish(sim_out_t *o, common_error_t *e);

/// Give the finished file its name. @return false and *e on failure
bool sim_out_publish(sim_out_t *o, common_error_t *e);

/// Remove a file that is not published.
void sim_out_drop(sim_out_t *o);

// The same for all outputs of one command, which appear together or not at all.

/// Open one after the other. @return false and *e on the first that cannot be written
bool sim_out_open_all(sim_out_t *outs, const char *const *names, const char *const *options, int n,
                      common_error_t *e);

/// Finish all, then publish all. @return false and *e on the first failure
bool sim_out_publish_all(sim_out_t *outs, int n, common_error_t *e);

void sim_out_drop_all(sim_out_t *outs, int n);

// Text; a failure is kept until finish.

void sim_out_text(sim_out_t *o, const char *text);
void sim_out_char(sim_out_t *o, char c);
void sim_out_integer(sim_out_t *o, int64_t value);

/// value * 10^-decimals with all its decimals.
void sim_out_decimal(sim_out_t *o, int64_t value, int decimals);

/// value rounded to decimals; |value| * 10^decimals < 2^62
void sim_out_real(sim_out_t *o, double value, int decimals);

// Columns behind the first of a line: a comma, then the value.

void sim_out_integer_column(sim_out_t *o, int64_t value);
void sim_out_decimal_column(sim_out_t *o, int64_t value, int decimals);
void sim_out_real_column(sim_out_t *o, double value, int decimals);
/// A word; `number` stands for it where the columns are numbers.
void sim_out_word_column(sim_out_t *o, const char *word, int number);

/// 0x and at least n_digits digits.
void sim_out_hex_column(sim_out_t *o, uint32_t value, int n_digits);

#endif
