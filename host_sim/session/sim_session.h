// SPDX-License-Identifier: Apache-2.0
/// sim_session: what every cut has in common, whoever controls it: the table, the design, the
/// workpiece, the gauges on it, and the progress of the cut.
///
///     open -> load_design -> place -> touch, touch, ... -> close
///
/// A cut by the firmware (sim_cut.h) and a cut by a controller on a bus (sim_watch.h) each hold one
/// session and differ only in how the lathe is moved and in how the cut ends.
#ifndef SIM_SESSION_H
#define SIM_SESSION_H

#include "cam_table.h"     // cam_table_t
#include "sim_config.h"    // sim_config_t
#include "sim_design.h"    // sim_design_t
#include "sim_inject.h"    // sim_inject_t
#include "sim_lathe.h"     // sim_sample_t
#include "sim_lobe_work.h" // sim_lobe_work_t
#include "sim_nose.h"      // sim_nose_t
#include "sim_scallop.h"   // sim_scallop_t
#include "sim_sections.h"  // sim_sections_t
#include "sim_work.h"      // sim_work_t
#include <stdbool.h>       // bool
#include <stddef.h>        // size_t
#include <stdint.h>        // uint8_t, uint32_t, uint64_t

enum { sim_session_max_injects = 32 };

/// Options of any cut.
typedef struct {
    sim_config_t config;
    const char *design_path; ///< NULL: gauge against the table itself, lobes by U alone
    uint64_t seed;           ///< of all noise
    double max_s;            ///< [s] of machine time after which the cut is given up
    double tolerance_um;     ///< largest form error that is good
    double nose_mm;          ///< radius of the tool's nose; 0: that of the machine file
    sim_inject_t inject[sim_session_max_injects];
    uint32_t n_injects;
} sim_session_options_t;

typedef struct {
    sim_session_options_t options;
    uint8_t *image; ///< own copy, so that a bit may flip
    cam_table_t table;
    sim_design_t design; ///< the drawing, which the part is judged by
    bool has_target;     ///< the table deliberately plays something else than the drawing
    sim_design_t target; ///< ... this surface
    sim_work_t work;
    sim_work_t control;      ///< errors against the target, when there is one
    sim_nose_t nose;         ///< of the tool
    sim_scallop_t scallop;   ///< made only when the tool has a nose
    sim_lobe_work_t lobes;   ///< of lobes only
    sim_sections_t sections; ///< made only when they are asked for
    double phase_turn;       ///< [turn] rotates the oval on the part
    double mean_rad_s;       ///< [rad/s] mean speed of the spindle that was commanded; 0: not known
    // of several passes
    double allowance_mm; ///< stock on the radius that this pass leaves
    double stock_mm;     ///< ... that the pass before has left, where has_stock
    bool has_stock;      ///< the blank of this pass is the drawing and that stock, no cylinder
    // progress
    double began_at_s;  ///< time of the first sample of cutting of all passes; below 0: not yet
    uint32_t n_waiting; ///< injections that have not happened
    double cut_at_s;    ///< time of the first sample of cutting; below 0: not yet
    double cut_at_turn; ///< true angle there
    double cut_turns, cut_s; ///< angle and time since then, while cutting
    // following error of U while cutting
    double following_max_um, following_sum_um2;
    uint64_t n_following;
    // last sample
    sim_sample_t at;
    bool is_on_part;        ///< at the height of the part, not in the air before or behind it
    bool is_cutting;        ///< the sample belongs to the surface that is judged
    bool has_touched;       ///< a sample has belonged to it
    double touched_at_turn; ///< angle of the first one in the sense of cutting
    double part_turn, z_mm, radius_mm, exact_mm;
} sim_session_t;

/// Check and copy a table.
/// @param s      12 MB, zero-initialised; to be closed in any case
/// @param image  of the table
/// @param name   of its file, for messages
/// @return       false and *e when the table is refused
bool sim_session_open(sim_session_t *s, const sim_session_options_t *options, const void *image,
                      size_t size, const char *name, common_error_t *e);

/// Load the design that the gauge compares with. @return false and *e when it is no good
bool sim_session_load_design(sim_session_t *s, common_error_t *e);

/// @return what the table plays: the target, or the drawing itself
sim_design_t *sim_session_played(sim_session_t *s);

/// @return the gauge of the controller's own error: against the target, or against the drawing
const sim_work_t *sim_session_control(const sim_session_t *s);

/// Put the blank into the lathe.
/// @param x_nm, z_nm  where X and Z stand at the start: off the blank, before the first height
void sim_session_place(sim_session_t *s, double *x_nm, double *z_nm);

/// Prepare the gauges for the next pass; the injections go on.
void sim_session_begin_pass(sim_session_t *s);

/// Take a sample of the tool: gauge it and count the progress.
/// @param is_cutting    full amplitude and depth; on the part the sample belongs to the surface
/// that
///                      is judged
/// @param following_nm  following error of U; counted while cutting
void sim_session_touch(sim_session_t *s, const sim_sample_t *at, bool is_cutting,
                       double following_nm);

/// @return [mm] by which the tip of a skirt's tool stood below the blank at the last sample; 0
/// where
///         it is clear, beside the part, or cuts lobes
double sim_session_depth_mm(const sim_session_t *s);

/// @return [turn] drawing's angle of the last sample, phase taken off, not wrapped: rises with M3,
///         falls with M4
double sim_session_turn(const sim_session_t *s);

/// Take the next injection that is due; each happens once. @return NULL when there is none
sim_inject_t *sim_session_next_inject(sim_session_t *s, double now_s);

/// @return [um] rms following error, 0 without samples
double sim_session_following_rms_um(const sim_session_t *s);

void sim_session_close(sim_session_t *s);

#endif
