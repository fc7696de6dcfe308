// SPDX-License-Identifier: Apache-2.0
/// sim_cut: a whole cut in virtual time, controlled by the firmware.
///
///     open -> tick, tick, ... until end is not sim_cut_running -> close
///
/// Opening loads the table into the firmware, sets its parameters and checks the feasibility. The
/// ticks then act as an operator with the firmware's own commands: enable, wait for the angle,
/// start, wait for the end. After a fault they continue until the tool is retracted. Only one cut
/// exists at a time, because a process has one controller and one port. After a tick the firmware's
/// status and trace, the lathe and the session show its results.
#ifndef SIM_CUT_H
#define SIM_CUT_H

#include "sim_port.h"    // sim_firmware_t, sim_port_t
#include "sim_removal.h" // sim_removal_t
#include "sim_session.h" // sim_session_t
#include "sim_work.h"    // sim_turns_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint64_t

enum { sim_cut_poll_ticks = 16 };

typedef struct {
    sim_session_options_t session; ///< max_s 0: twice the plan plus a minute
    sim_wishes_t wishes;           ///< override the machine file's [controller]
    double rpm;                    ///< 0: the table's
    double feed_mm;                ///< 0: the table's
    bool is_without_feed_forward, is_without_lead, is_without_learning;
    double trace_every; ///< [ticks] per line of the trace; below 1: every tick
    double slice_s;     ///< [s] slice of the removal; 0: a 120th of the mean turn
    double kc_n_mm2;    ///< specific cutting force
    double kc_exponent; ///< its size effect; 0: none
    double nose_mm;     ///< radius of the tool's nose; 0: no surface between tracks
    bool has_window;    ///< heights of that surface are given; default: four feeds in the middle
    double window_first_mm, window_last_mm;
    int n_sections;                       ///< given heights of sections
    double section_mm[sim_sections_most]; ///< rising
    bool has_sections; ///< make sections and lines; default: five heights, or one per lobe
    double tip_mm;     ///< tip radius of the tool that turns lobes; 0: 0.4 mm
    double max_turns;  ///< operator's stop after this many turns of cutting; 0: the whole part
} sim_cut_options_t;

typedef enum {
    sim_cut_running,
    sim_cut_done,     ///< the controller is ready again
    sim_cut_fault,    ///< fault, tool retracted
    sim_cut_timeout,  ///< max_s has passed
    sim_cut_refused,  ///< the controller refused a command: `refusal`
    sim_cut_unsteady, ///< the controller ended the start, because the spindle was not steady
} sim_cut_end_t;

/// Result of a pass.
typedef struct {
    uint64_t n;          ///< samples
    double allowance_mm; ///< stock to leave
    double rpm, feed_mm, turns;
    double end_s;          ///< [s] machine time at its end
    double max_um, rms_um; ///< form error against the drawing and the stock
    double gouge_um;       ///< deepest cut below them, in any state
    double depth_min_mm, depth_max_mm;
    double removed_mm3;
    sim_spread_t rate, chip_force;
} sim_pass_result_t;

typedef struct {
    sim_cut_options_t options; ///< those of the session are in force there
    sim_session_t session;
    sim_port_t port;
    sim_removal_t removal; ///< skirts only
    sim_turns_t turns;     ///< error of each turn
    bool has_slice;        ///< the last tick finished a slice of removal
    sim_firmware_t firmware;
    cam_params_t params; ///< as set
    cam_params_t here;   ///< with the values of the present pass
    uint32_t first_pass, pass;
    sim_pass_result_t result[cam_table_max_passes]; ///< of the passes before it
    cam_refusal_t feasibility;
    double max_s;
    double full_first_turn, full_last_turn; ///< of the pass: range of turns at full feed
    // progress
    sim_cut_end_t end;
    cam_err_t refusal;
    cam_state_t state; ///< in the last tick
    bool is_started;   ///< start was accepted
    bool is_near;      ///< ... and the approach has begun
    bool is_stopped;   ///< ended by an operator's stop
    uint32_t until_poll;
    uint32_t n_polls;
    uint64_t n_ticks;
    double fault_s; ///< time of the first fault; below 0: none
    double fault_turn, fault_z_mm;
    cam_state_t fault_state; ///< state when the fault occurred
} sim_cut_t;

/// @param cut    16 MB, zero-initialised: what a cut does not use then takes no memory
/// @param image  image of a table; copied
/// @param name   name of the table file, for messages
/// @return       false and *e when the input is bad or the speed infeasible; then nothing to close
bool sim_cut_open(sim_cut_t *cut, const sim_cut_options_t *options, const void *image, size_t size,
                  const char *name, common_error_t *e);

/// @return the parameters of the machine file, overridden by those of the command line
sim_wishes_t sim_cut_wishes(const sim_cut_options_t *o);

/// Run one tick. The last one sets cut->end.
void sim_cut_tick(sim_cut_t *cut);

/// Run one tick without an operator.
void sim_cut_idle(sim_cut_t *cut);

void sim_cut_close(sim_cut_t *cut);

/// @return the controller's status after the last tick
cam_status_t sim_cut_status(const sim_cut_t *cut);

/// @return [mm] present feed per turn; for a ring-helix the distance of its rings
double sim_cut_feed_mm(const sim_cut_t *cut);

/// @return true when Z is geared along a ring-helix
bool sim_cut_has_rings(const sim_cut_t *cut);

/// @return [turn] planned length of the state cutting
double sim_cut_planned_turns(const sim_cut_t *cut);

/// @return false when the operator, or the limit of turns, ended the cut before its end
bool sim_cut_is_whole(const sim_cut_t *cut);

/// Check whether the surface was gauged; otherwise it is not known to be good.
/// @return false when nothing was cut to full depth, or a complete part has a lobe that was not
///         gauged all round, or a zone without a sample; if the operator ends a cut early, the part
///         that was cut counts
bool sim_cut_is_gauged(const sim_cut_t *cut);

/// The contact never returns to a dexel within a turn, so a lobe with as many samples as dexels was
/// gauged over a whole turn.
/// @return first lobe with fewer samples; the number of lobes when there is none
uint32_t sim_cut_lobe_without_turn(const sim_cut_t *cut);

/// @return true when what was to be cut ended well, was gauged completely, and is within the
///         tolerance; the part is good only if it is whole, too
bool sim_cut_is_good(const sim_cut_t *cut);

/// @return [r/min] mean speed of the spindle
double sim_cut_rpm(const sim_cut_t *cut);

/// @return [r/min] a better speed where the encoder's counts do not average at the mean one; 0:
/// they do
double sim_cut_averaging_rpm(const sim_cut_t *cut);

/// @return whether U takes forces and its loop follows from the machine file, not from a
/// measurement
bool sim_cut_is_loop_assumed(const sim_cut_t *cut);

/// @return "done", "stopped", "fault", "timeout", "refused" or "unsteady"
const char *sim_cut_end_name(const sim_cut_t *cut);

#endif
