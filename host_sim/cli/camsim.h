// SPDX-License-Identifier: Apache-2.0
/// camsim: the command line of the simulator.
///
///     camsim eval TABLE < points.csv > values.csv
///     camsim run TABLE [options]
///     camsim bus TABLE --can IFACE [options]
///
/// Exit status: 0 done; 1 the cut ended in a fault, in time-out, out of tolerance or was not
/// gauged; 2 wrong usage or bad input or output. Errors are one line on stderr: file, field, value,
/// remedy.
#ifndef CAMSIM_H
#define CAMSIM_H

#include "cam_table.h" // cam_table_t
#include "sim_cut.h"   // sim_cut_options_t, sim_cut_t
#include "sim_error.h" // sim_error_t
#include "sim_file.h"  // sim_file_t
#include <stdbool.h>   // bool
#include <stddef.h>    // size_t

#define CAMSIM_VERSION "0.1.0"

enum { camsim_done = 0, camsim_not_good = 1, camsim_wrong = 2 };
enum { camsim_max_table_bytes = 64 * 1024 * 1024 };

/// The commands; argv[0] is the command's name.
int camsim_eval(int argc, char **argv);
int camsim_run(int argc, char **argv);
int camsim_bus(int argc, char **argv);

/// Print an error line. @return camsim_wrong
int camsim_complain(const sim_error_t *e);

/// What `run`, or `bus` as far as they share it, was asked for.
typedef struct {
    const char *command; ///< for messages
    const char *table_path;
    const char *machine_path;
    const char *trace_path, *surface_path, *summary_path, *removal_path;
    const char *scallop_path; ///< all of them NULL: not wanted
    char design_path[4096];   ///< of the gauge's reference; "" when there is none
    char target_image[4096];  ///< where it was built; not used when the user gives one
    bool is_progress_shown;
    bool is_help;
    double tolerance_um;
    sim_cut_options_t cut;
} camsim_options_t;

/// Read the options of `run`.
/// @param argv  argv[0] is the command
/// @return false and *e when something is wrong
bool camsim_options_read(camsim_options_t *o, int argc, char **argv, sim_error_t *e);

/// Print the help of `run`.
void camsim_options_help(void);

#endif
