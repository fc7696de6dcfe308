// SPDX-License-Identifier: Apache-2.0
/// camsim_bus: the machine as nodes on a CAN bus, a whole cut with a controller in another process.
///
/// Its parts: options (camsim_bus_options.c), the loop (camsim_bus.c), trace and summary
/// (camsim_bus_out.c). Trace: one line per period, columns as in camsim run first (`state` and
/// `faults` as the controller told them last, "-" and 0 before), then
///     true_turn,true_z_mm,radius_mm,error_nm   the truth at the SYNC
///     enable,fault,in_cut                      lines of the controller
///     syncs                                    SYNCs until then
///     encoder_counts                           spoken last before the SYNC
///     A_control,A_status,A_target,A_actual,A_offset for A = u, x, z, spindle; control and status
///     words in hexadecimal; the spindle without offset, its speeds in r/min / 1000
#ifndef CAMSIM_BUS_H
#define CAMSIM_BUS_H

#include "camsim.h"      // camsim_options_t
#include "camsim_link.h" // camsim_link_t
#include "camsim_out.h"  // camsim_out_t
#include "sim_bus.h"     // sim_bus_t
#include "sim_design.h"  // sim_design_t
#include "sim_work.h"    // sim_work_t

typedef struct {
    camsim_options_t common; ///< those shared with camsim run
    const char *interface, *chip;
    double tick_hz, guard_ms, heartbeat_ms, encoder_modulus;
    bool is_foreign[sim_bus_n_nodes];
    bool is_staying; ///< goes on after the end until a signal
} camsim_bus_options_t;

/// How it ended.
typedef enum {
    camsim_bus_running,
    camsim_bus_done,    ///< cut, and the controller is ready again
    camsim_bus_fault,   ///< fault, enable low, all at rest
    camsim_bus_lost,    ///< the controller has gone, all at rest
    camsim_bus_timeout, ///< --max-seconds are over
    camsim_bus_stopped, ///< by a signal
} camsim_bus_end_t;

typedef struct {
    camsim_bus_options_t options;
    uint8_t *image;
    cam_table_t table;
    sim_design_t design;
    sim_work_t work;
    sim_bus_t bus;
    camsim_link_t link;
    sim_bus_outputs_t outputs;
    camsim_out_t trace, surface, summary;
    camsim_bus_end_t end;
    double part_turn, z_mm, radius_mm, exact_mm; ///< last sample
    double cut_at_s, cut_s;                      ///< first sample of cutting, time in it
    double cut_at_turn, cut_turns;
    double quiet_s; ///< since when the end has been in sight; below 0: it is not
    camsim_bus_end_t quiet_end;
    double fault_s;   ///< first sight of a fault, below 0: none
    double stopped_s; ///< first moment of rest after the last SYNC or fault; below 0: none
    uint32_t faults;  ///< all that were told
    double following_max_um, following_sum_um2;
} camsim_bus_t;

/// @return false and *e when something is wrong
bool camsim_bus_options_read(camsim_bus_options_t *o, int argc, char **argv, sim_error_t *e);
void camsim_bus_options_help(void);

void camsim_bus_trace_header(camsim_out_t *o);
void camsim_bus_trace_line(camsim_bus_t *b);

/// @return false when memory is short
bool camsim_bus_summary(camsim_bus_t *b);

/// @return "done", "fault", "lost", "timeout" or "stopped"
const char *camsim_bus_end_name(camsim_bus_end_t end);

#endif
