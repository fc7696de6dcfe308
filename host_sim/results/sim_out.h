// SPDX-License-Identifier: Apache-2.0
/// sim_out: output files that appear complete or not at all, and their text; or the same columns as
/// numbers in memory.
///
/// The output goes to a temporary file next to the target, which gets its final name when
/// everything is on disk. Interrupted and failed runs leave no files. A target that is not a
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
    const char *name;         ///< as given by the user; NULL: not wanted, all calls do nothing
    char final[sim_out_path]; ///< links resolved
    char temporary[sim_out_path + 16]; ///< "" when written directly
    sim_values_t *values;              ///< NULL: text in a file
    FILE *stream;
    int error; ///< errno of the first failure, 0
    size_t n;
    char buffer[sim_out_buffer];
} sim_out_t;

/// On SIGINT, SIGTERM, SIGHUP and SIGPIPE remove temporary files, then die by the signal.
void sim_out_watch_signals(void);

/// @param name    name of the target, NULL: not wanted
/// @param option  option that named it, for messages
/// @return        false and *e when it cannot be written
bool sim_out_open(sim_out_t *o, const char *name, const char *option, common_error_t *e);

/// Collect the columns as numbers in memory; finishing, publishing and dropping then do nothing.
/// @param name  of the output, for messages
void sim_out_open_values(sim_out_t *o, const char *name, sim_values_t *values);

/// Write text to a stream; finishing or dropping closes it.
/// @param name  of the output, for messages
void sim_out_open_stream(sim_out_t *o, const char *name, FILE *stream);

/// Flush to disk and close. @return false and *e on any failure
bool sim_out_finish(sim_out_t *o, common_error_t *e);

/// Give the finished file its name. @return false and *e on failure
bool sim_out_publish(sim_out_t *o, common_error_t *e);

/// Remove a file that was not published.
void sim_out_drop(sim_out_t *o);

// Likewise for all outputs of a command, which appear together or not at all.

/// Open one after the other. @return false and *e on the first that cannot be written
bool sim_out_open_all(sim_out_t *outs, const char *const *names, const char *const *options, int n,
                      common_error_t *e);

/// Finish all, then publish all. @return false and *e on the first failure
bool sim_out_publish_all(sim_out_t *outs, int n, common_error_t *e);

void sim_out_drop_all(sim_out_t *outs, int n);

// Text; a failure is reported by finish.

void sim_out_text(sim_out_t *o, const char *text);
void sim_out_char(sim_out_t *o, char c);
void sim_out_integer(sim_out_t *o, int64_t value);

/// value * 10^-decimals with all decimals.
void sim_out_decimal(sim_out_t *o, int64_t value, int decimals);

/// value rounded to decimals; |value| * 10^decimals < 2^62
void sim_out_real(sim_out_t *o, double value, int decimals);

// Columns after the first: a comma, then the value.

void sim_out_integer_column(sim_out_t *o, int64_t value);
void sim_out_decimal_column(sim_out_t *o, int64_t value, int decimals);
void sim_out_real_column(sim_out_t *o, double value, int decimals);
/// A word, or `number` for numeric columns.
void sim_out_word_column(sim_out_t *o, const char *word, int number);

/// 0x and at least n_digits digits.
void sim_out_hex_column(sim_out_t *o, uint32_t value, int n_digits);

#endif
