// SPDX-License-Identifier: Apache-2.0
/// sim_api: the simulator as a library, for programs in any language: `camsim run` without files.
///
///     open -> begin -> run, run, ... -> finish -> rows, summary -> begin -> ... -> close
///
/// A cut is described by the words of a command line of `camsim run`, so options, ranges, defaults
/// and messages are the same, and so are the results: the rows are those of the files of
/// `camsim run`, the summary is its text. An option that names a file, as `--trace F.csv`, asks for
/// a table of rows; nothing is printed and nothing is written.
///
/// Firmware and port are one per process, as on a machine, so there is one cut at a time in a
/// process: `begin` refuses while another session is between begin and end. What one cut did leaves
/// nothing behind for the next. Not for several threads at once. A defect that stops the firmware
/// (hal_halt) ends the process.
///
/// Between the marks stands plain C without a preprocessor: other languages read it as it is.
#ifndef SIM_API_H
#define SIM_API_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // uint64_t

#if defined(__cplusplus)
extern "C" {
#endif
#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

// [declarations]

/// A session: memory and, between begin and end, one cut.
typedef struct sim_api sim_api_t;

/// @return a session, to be closed; NULL when there is no memory
sim_api_t *sim_api_open(void);

/// End the cut and free everything, the results too. NULL does nothing.
void sim_api_close(sim_api_t *s);

/// @return version of the simulator, as in its summaries
const char *sim_api_version(void);

/// @return the keys of machine files, as sim_config_keys()
const char *sim_api_machine_keys(void);

/// @return the line that says what was wrong with the last call that failed, as `camsim` prints it
///         after its name; valid until the next call
const char *sim_api_error(const sim_api_t *s);

/// Begin a cut; one that has not ended is ended, and results are freed.
/// @param words    of `camsim run`: the table, options
/// @param machine  text of a machine file; NULL: that of --machine, or the default machine
/// @param name     of the machine's text, for messages
/// @return         false when camsim would refuse (exit status 2)
bool sim_api_begin(sim_api_t *s, const char *const *words, int n_words, const char *machine,
                   size_t machine_size, const char *name);

/// Give the length of the cut that was begun: turns of cutting, time on the machine, all passes,
/// rehearsals and ramps included.
void sim_api_plan(const sim_api_t *s, double *turns, double *seconds, double *tick_hz);

/// @param output  trace, surface, removal, scallop, sections or summary
/// @return        file that the option of that name gives; NULL: not asked for
const char *sim_api_path(const sim_api_t *s, const char *output);

/// Go on with the cut.
/// @param n_ticks  at most so many
/// @return         true while there is more to do
bool sim_api_run(sim_api_t *s, uint64_t n_ticks);

/// @return share of the planned machine time that is done, 0 .. 1
double sim_api_progress(const sim_api_t *s);

/// Make the results of a cut, at its end or before.
/// @param wall_s  [s] computing time, for the summary
/// @return        exit status of `camsim run`: 0 good; 1 fault, time-out, out of tolerance or not
///                gauged; 2 refused or no memory; sim_api_error() says why
int sim_api_finish(sim_api_t *s, double wall_s);

/// @param table  trace, surface, removal, scallop or sections
/// @return       its columns, "NAME:FORMAT,NAME:FORMAT,..": a number of decimals, x4 for a
///               hexadecimal mask, s for a state by its number; NULL: not asked for
const char *sim_api_columns(const sim_api_t *s, const char *table);

/// @param n  numbers in all
/// @return   rows, one after the other; a number is in units of its column's last decimal. Rows of
///           trace and removal come while the cut runs, the others when it is finished
const int64_t *sim_api_rows(const sim_api_t *s, const char *table, size_t *n);

/// Forget the rows, so that a long cut needs little memory.
void sim_api_drop(sim_api_t *s, const char *table);

/// @return the summary, JSON; empty before sim_api_finish(), and where that had no memory
const char *sim_api_summary(const sim_api_t *s);

/// End the cut and free its results, so that another session may begin one.
void sim_api_end(sim_api_t *s);

// [end of declarations]

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif
#if defined(__cplusplus)
}
#endif

#endif
