// SPDX-License-Identifier: Apache-2.0
/// sim_out: output files that appear complete or not at all, and the text of tables of results.
///
/// The output goes to a temporary file next to the target, which gets its final name when
/// everything is on disk. Interrupted and failed runs leave no files. A target that is not a
/// regular file (a pipe, /dev/stdout) is written directly.
#ifndef SIM_OUT_H
#define SIM_OUT_H

#include "common_error.h" // common_error_t
#include "sim_rows.h"     // sim_rows_t
#include <stdbool.h>      // bool
#include <stdio.h>        // FILE

enum { sim_out_path = 4096, sim_out_buffer = 1 << 16 };

typedef struct {
    const char *name;         ///< as given by the user; NULL: not wanted, all calls do nothing
    char final[sim_out_path]; ///< links resolved
    char temporary[sim_out_path + 16]; ///< "" when written directly
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

// All outputs of a command, which appear together or not at all.

/// Open one after the other. @return false and *e on the first that cannot be written
bool sim_out_open_all(sim_out_t *outs, const char *const *names, const char *const *options, int n,
                      common_error_t *e);

/// Flush all to disk and close them, then give them their names. @return false and *e on the first
/// failure
bool sim_out_publish_all(sim_out_t *outs, int n, common_error_t *e);

/// Remove files that were not published.
void sim_out_drop_all(sim_out_t *outs, int n);

// Text; sim_out_publish_all() reports a failure.

void sim_out_text(sim_out_t *o, const char *text);

/// Write the names of the columns, separated by commas, as a line.
void sim_out_header(sim_out_t *o, const sim_rows_t *t);

/// Write all rows as lines, and drop them.
void sim_out_rows(sim_out_t *o, sim_rows_t *t);

#endif
