// SPDX-License-Identifier: Apache-2.0
/// sim_session: the common part of every cut: table, design, workpiece, gauges and progress.
///
///     open -> load_design -> place -> touch, touch, ... -> close
///
/// A cut by the firmware (sim_cut.h) and a cut by a controller on a bus (sim_watch.h) each hold one
/// session; they differ only in how the lathe is moved and how the cut ends.
#ifndef SIM_SESSION_H
#define SIM_SESSION_H

#include "cam_table.h"     // cam_table_t
#include "sim_config.h"    // sim_config_t
#include "sim_design.h"    // sim_design_t
#include "sim_inject.h"    // sim_inject_t
#include "sim_lathe.h"     // sim_sample_t
#include "sim_lobe_work.h" // sim_lobe_work_t
#include "sim_work.h"      // sim_nose_t, sim_work_t, sim_sections_t
#include "sim_scallop.h"   // sim_scallop_t
#include <stdbool.h>       // bool
#include <stddef.h>        // size_t
#include <stdint.h>        // uint8_t, uint32_t, uint64_t

enum { sim_session_max_injects = 32 };

/// Options of any cut.
typedef struct {
    sim_config_t config;
    const char *design_path; ///< NULL: gauge against the table itself, lobes by U only
    uint64_t seed;           ///< of all noise
    double max_s;            ///< [s] machine time after which the cut is aborted
    double tolerance_um;     ///< largest good form error
    double nose_mm;          ///< radius of the tool's nose; 0: that of the machine file
    bool has_map;            ///< the gauges keep the map of the surface
    sim_inject_t inject[sim_session_max_injects];
    uint32_t n_injects;
} sim_session_options_t;

typedef struct {
    sim_session_options_t options;
    uint8_t *image; ///< own copy, in which a bit may flip
    cam_table_t table;
    sim_design_t design; ///< the drawing, the reference of the verdict
    bool has_target;     ///< the table deliberately deviates from the drawing
    sim_design_t target; ///< the surface that it plays
    sim_work_t work;
    sim_work_t control;      ///< errors against the target, if any
    sim_nose_t nose;         ///< of the tool
    sim_scallop_t scallop;   ///< only with a nose of the tool
    sim_lobe_work_t lobes;   ///< lobes only
    sim_sections_t sections; ///< only on request
    double phase_turn;       ///< [turn] rotation of the oval on the part
    double mean_rad_s;       ///< [rad/s] commanded mean spindle speed; 0: unknown
    double blank_mm;         ///< radius of the blank, a cylinder
    // several passes
    double allowance_mm; ///< stock on the radius left by this pass
    double stock_mm;     ///< stock left by the pass before, if has_stock
    bool has_stock;      ///< the blank of this pass is the drawing plus that stock, not a cylinder
    // progress
    double began_at_s;  ///< time of the first sample of cutting of all passes; below 0: not yet
    uint32_t n_waiting; ///< injections still to happen
    double cut_at_s;    ///< time of the first sample of cutting; below 0: not yet
    double cut_at_turn; ///< true angle there
    double cut_turns, cut_s; ///< angle and time since then, while cutting
    // following error of U while cutting
    double following_max_um, following_sum_um2;
    uint64_t n_following;
    // last sample
    sim_sample_t at;
    bool is_on_part;        ///< at a height of the part, not in the air before or after it
    sim_place_kind_t place; ///< what the surface is there
    bool is_cutting;        ///< the sample belongs to the judged surface
    bool is_rough;          ///< the tool cuts at a band, but not in its last pass
    double band_feed_mm;    ///< feed per turn of the pass over a band; 0: of the table
    bool has_touched;       ///< a sample has belonged to the judged surface
    double touched_at_turn; ///< angle of the first one in the sense of cutting
    double part_turn, z_mm, radius_mm, exact_mm;
} sim_session_t;

/// Check and copy a table.
/// @param s      12 MB, zero-initialised; close it also on failure
/// @param image  of the table
/// @param name   name of its file, for messages
/// @return       false and *e when the table is refused
bool sim_session_open(sim_session_t *s, const sim_session_options_t *options, const void *image,
                      size_t size, const char *name, common_error_t *e);

/// Load the gauge's design. @return false and *e when it is not valid
bool sim_session_load_design(sim_session_t *s, common_error_t *e);

/// @return the surface that the table plays: the target, or the drawing
sim_design_t *sim_session_played(sim_session_t *s);

/// @return the gauge of the control error: against the target, or else the drawing
const sim_work_t *sim_session_control(const sim_session_t *s);

/// Mount the blank.
/// @param x_nm, z_nm  X and Z at the start: off the blank, before the first height
void sim_session_place(sim_session_t *s, double *x_nm, double *z_nm);

/// Prepare the gauges for the next pass; injections continue.
void sim_session_begin_pass(sim_session_t *s);

/// Take a sample of the tool: gauge it and update the progress.
/// @param is_cutting    full amplitude and depth; a sample on the part belongs to the judged
///                      surface
/// @param following_nm  following error of U; counted while cutting
void sim_session_touch(sim_session_t *s, const sim_sample_t *at, bool is_cutting,
                       double following_nm);

/// @return [mm] depth of a skirt's tool tip below the blank at the last sample; 0 if clear, beside
///         the part, or on lobes
double sim_session_depth_mm(const sim_session_t *s);

/// @return [turn] drawing's angle of the last sample less the phase, not wrapped: rises with M3,
///         falls with M4
double sim_session_turn(const sim_session_t *s);

/// Get the next due injection; each happens once. @return NULL when there is none
sim_inject_t *sim_session_next_inject(sim_session_t *s, double now_s);

/// @return whether the gauged surface is within its tolerances, those of zones included
bool sim_session_is_within(const sim_session_t *s);

/// @return the first zone in which nothing was judged; NULL when there is none
const sim_zone_t *sim_session_zone_without_sample(const sim_session_t *s);

/// @return [um] rms following error, 0 without samples
double sim_session_following_rms_um(const sim_session_t *s);

void sim_session_close(sim_session_t *s);

#endif
