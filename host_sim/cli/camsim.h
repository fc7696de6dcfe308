// SPDX-License-Identifier: Apache-2.0
/// camsim: the command line of the simulator.
///
///     camsim eval TABLE < points.csv > values.csv
///     camsim run TABLE [options]
///     camsim bus TABLE --can IFACE [options]
///     camsim identify TABLE --wave F.csv --record F.csv [options]
///     camsim live TABLE --role lathe|controller --wire FD [options]
///     camsim params TABLE [options]
///
/// Exit status: 0 done; 1 the cut ended in a fault, in time-out, out of tolerance or was not
/// gauged; 2 wrong usage or bad input or output. Errors are one line on stderr: file, field, value,
/// remedy.
#ifndef CAMSIM_H
#define CAMSIM_H

#include "camsim_parse.h" // camsim_set_t
#include "common_error.h" // common_error_t
#include "sim_cut.h"      // sim_cut_options_t, sim_cut_t
#include "sim_file.h"     // sim_file_t
#include "sim_out.h"      // sim_out_t
#include "sim_tables.h"   // sim_n_tables
#include <stdbool.h>      // bool
#include <stddef.h>       // size_t

enum { camsim_done = 0, camsim_not_good = 1, camsim_wrong = 2 };
enum { camsim_max_table_bytes = 64 * 1024 * 1024 };

/// Output files, in order of opening: the tables, then the summary.
enum { camsim_summary = sim_n_tables, camsim_n_outs };

/// Names of the options of the outputs, with --.
extern const char *const camsim_out_option[camsim_n_outs];

/// The commands; argv[0] is the command's name.
int camsim_eval(int argc, char **argv);
int camsim_run(int argc, char **argv);
int camsim_bus(int argc, char **argv);
int camsim_identify(int argc, char **argv);
int camsim_live(int argc, char **argv);
int camsim_params(int argc, char **argv);

/// Print an error line. @return camsim_wrong
int camsim_complain(const common_error_t *e);

/// The options of `run`; `bus` shares most of them.
typedef struct {
    const char *command; ///< for messages
    const char *table_path;
    const char *machine_path;
    const char *out_path[camsim_n_outs]; ///< NULL: not wanted
    char design_path[4096];              ///< NAME.json next to the table, existing or not
    bool is_progress_shown;
    bool is_help;
    double slice_us, seed; ///< as given; cut holds them, too
    sim_cut_options_t cut;
} camsim_options_t;

/// Read the options of `run`.
/// @param argv  argv[0] is the command
/// @return false and *e when something is wrong
bool camsim_options_read(camsim_options_t *o, int argc, char **argv, common_error_t *e);

/// Read these, and own options of another command.
bool camsim_options_read_with(camsim_options_t *o, camsim_set_t own, int argc, char **argv,
                              common_error_t *e);

/// Print the help of `run`.
void camsim_options_help(void);

/// Read the table and open its cut. @return false and *e when something is wrong
bool camsim_open_cut(const camsim_options_t *o, sim_cut_t *cut, common_error_t *e);

/// Write a summary, unless it is not wanted, and free it; then publish all outputs.
/// @param summary  NULL: there was not enough memory
/// @return         false and *e when something cannot be written
bool camsim_publish(sim_out_t *outs, char *summary, common_error_t *e);

/// Name the first retired parameter that an option or the machine file gives.
void camsim_warn_of_retired(const camsim_options_t *o);

/// Warn when the gauge has no design to compare with.
void camsim_warn_of_design(const camsim_options_t *o);

/// Print the results of a cut by the firmware.
void camsim_print_cut(const sim_cut_t *cut, double wall_s);

/// Name the place that is out of tolerance: a zone, or the surface beside all zones.
void camsim_explain_form(const sim_session_t *s, const char *table, const char *remedy,
                         common_error_t *e);

/// Print what was found in each zone.
void camsim_print_zones(const sim_session_t *s);

/// Judge a cut by the firmware.
/// @param table  path of the table
/// @param e      the reason, when it is not good
/// @return       exit status
int camsim_judge_cut(const sim_cut_t *cut, const char *table, common_error_t *e);

/// Refuse options that do not apply to lobes. The table shows whether there are lobes, since the
/// design may be missing.
/// @return false and *e when there is one
bool camsim_check_lobes(const camsim_options_t *o, const sim_cut_t *cut, common_error_t *e);

#endif
