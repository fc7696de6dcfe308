// SPDX-License-Identifier: Apache-2.0
/// sim_cut: one whole cut in virtual time, controlled by the firmware of this process or of a
/// target.
///
///     open -> tick, tick, ... until end is not sim_cut_running -> close
///
/// Opening loads the table into the firmware, sets its parameters and checks the feasibility. The
/// ticks then do what an operator does, by the firmware's own commands: enable, wait for the angle,
/// start, wait for the end. After a fault they go on until the tool is retracted. There is one cut
/// at a time, because controller and port are one per process. Between ticks the firmware's status
/// and trace, the lathe and the session show what the last tick did.
#ifndef SIM_CUT_H
#define SIM_CUT_H

#include "sim_firmware.h" // sim_firmware_t
#include "sim_port.h"     // sim_port_t
#include "sim_removal.h"  // sim_removal_t
#include "sim_session.h"  // sim_session_t
#include "sim_switches.h" // sim_switches_t
#include "sim_turns.h"    // sim_turns_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint64_t

enum { sim_cut_poll_ticks = 16 };

typedef struct {
    sim_session_options_t session; ///< max_s 0: twice engaging, cut and disengaging, and a minute
    sim_wishes_t wishes;           ///< overrule the machine file's [controller]
    double rpm;                    ///< 0: the table's
    double feed_mm;                ///< 0: the table's
    bool is_without_feed_forward, is_without_lead;
    double trace_every; ///< [ticks] from line to line of the trace; below 1: every tick
    bool is_traced;     ///< the firmware records every tick; drain sim_firmware_trace()
    double slice_s;     ///< [s] of the removal measured; 0: a 120th of the mean turn
    double kc_n_mm2;    ///< specific cutting force
    double kc_exponent; ///< of its size effect; 0: none
    double nose_mm;     ///< radius of the tool's nose; 0: the surface between tracks is not made
    bool has_window;    ///< heights of that surface are given; else four feeds in the middle
    double window_first_mm, window_last_mm;
    int n_sections;                       ///< heights of sections that are given
    double section_mm[sim_sections_most]; ///< ... rising
    bool has_sections;  ///< sections and lines are made; without heights at five, or in each lobe
    double tip_mm;      ///< radius of the tool that turns lobes; 0: 0.4 mm
    double max_turns;   ///< end the cut (operator's stop) after so many turns of cutting; 0: the
                        ///< whole part
    const char *target; ///< of sim_target.h; NULL: the firmware runs in this process
    const char *target_image; ///< path of its image
} sim_cut_options_t;

typedef enum {
    sim_cut_running,
    sim_cut_done,    ///< the controller is ready again
    sim_cut_fault,   ///< ended in a fault, tool retracted
    sim_cut_timeout, ///< max_s is over
    sim_cut_refused, ///< the controller refused a command; `refusal` says why
    sim_cut_lost,    ///< the target does not answer any more; sim_firmware_is_lost() says why
} sim_cut_end_t;

/// What a pass came to.
typedef struct {
    uint64_t n;          ///< samples
    double allowance_mm; ///< stock that it had to leave
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
    sim_removal_t removal;   ///< of a skirt only
    sim_turns_t turns;       ///< error of each turn
    sim_switches_t switches; ///< where the position switches act
    bool has_slice;          ///< the last tick finished a slice of the removal
    sim_firmware_t firmware;
    cam_params_t params; ///< as set
    cam_params_t here;   ///< with the numbers of the pass that is cut
    uint32_t first_pass, pass;
    sim_pass_result_t result[cam_table_max_passes]; ///< of those before it
    cam_feasibility_t feasibility;
    double max_s;
    // progress
    sim_cut_end_t end;
    cam_err_t refusal;
    cam_state_t state; ///< in the last tick
    bool is_started;   ///< start was accepted
    bool is_stopped;   ///< ended by the operator's stop
    uint32_t until_poll;
    uint32_t n_polls;
    uint64_t n_ticks;
    double fault_s; ///< time of the first fault; below 0: none
    double fault_turn, fault_z_mm;
    cam_state_t fault_state; ///< state in which the fault struck
} sim_cut_t;

/// @param cut    16 MB: allocate it
/// @param image  of a table; copied
/// @param name   of the table file, for messages
/// @return       false and *e when the input is no good or the speed infeasible; nothing to close
/// then
bool sim_cut_open(sim_cut_t *cut, const sim_cut_options_t *options, const void *image, size_t size,
                  const char *name, common_error_t *e);

/// @return the parameters that the machine file gives, overruled by those of the command line
sim_wishes_t sim_cut_wishes(const sim_cut_options_t *o);

/// Run one tick. Sets cut->end when it was the last.
void sim_cut_tick(sim_cut_t *cut);

/// Run one tick without an operator.
void sim_cut_idle(sim_cut_t *cut);

void sim_cut_close(sim_cut_t *cut);

/// @return what the controller published in the last tick
cam_status_t sim_cut_status(const sim_cut_t *cut);

/// @return [mm] feed per turn in force; of a ring-helix the distance of its rings
double sim_cut_feed_mm(const sim_cut_t *cut);

/// Place the window of the surface between tracks anew, for the feed of a pass.
void sim_cut_place_scallop(sim_cut_t *cut);

/// @param here  parameters of a pass
/// @return      [turn] length of its cutting state as planned
double sim_cut_turns_of(const cam_table_t *table, const cam_params_t *here);

/// @return true when Z is geared along a ring-helix
bool sim_cut_has_rings(const sim_cut_t *cut);

/// @return [turn] length of the cutting state as planned
double sim_cut_planned_turns(const sim_cut_t *cut);

/// A surface that no gauge has seen is not known to be good.
/// @return false when nothing was cut to full depth, or a lobe of a part that was cut to its end
///         was not gauged all round; of a cut that the operator ends early what was cut counts
bool sim_cut_is_gauged(const sim_cut_t *cut);

/// The contact never returns to a dexel within a turn, so a lobe with as many samples as dexels has
/// been gauged over a whole turn.
/// @return first lobe with fewer samples; the number of lobes when there is none
uint32_t sim_cut_lobe_without_turn(const sim_cut_t *cut);

/// @return true when the cut ended well, all of it was gauged, and the form error is within the
///         tolerance
bool sim_cut_is_good(const sim_cut_t *cut);

/// @return [r/min] mean speed of the spindle
double sim_cut_rpm(const sim_cut_t *cut);

/// @return "done", "stopped", "fault", "timeout", "refused" or "lost"
const char *sim_cut_end_name(const sim_cut_t *cut);

#endif
