// SPDX-License-Identifier: Apache-2.0
/// sim_inject: faults and actions of the operator, and when they happen: KIND@SECONDS[:VALUE].
///
/// SECONDS count from the first tick of the state cutting; tSECONDS count from the start of the
/// run. Each happens once.
///
/// | kind | value | what happens |
/// |---|---|---|
/// | estop | | the emergency-stop chain opens |
/// | drive | | the drives report not ready |
/// | bus | | a node of the bus goes silent; the drives still report |
/// | lost-counts | counts | the encoder loses this many counts |
/// | encoder-jump | counts | the encoder gains this many counts |
/// | encoder-stuck | | the counter stops |
/// | encoder-rate | percent | it counts faster by this, below 0 slower: -50 is half of the counts |
/// | encoder-dither | counts | it stops and dithers by this many counts |
/// | index-dead | | no more index edges |
/// | late-tick | percent | one tick is late by this share of a period |
/// | clock-drift | ppm | the controller's clock runs fast by this, below 0 slow |
/// | tick-jitter | percent | every tick is late by up to this share of a period, at random |
/// | tick-burst | percent | one of 16 ticks, at random, is late by this share |
/// | tick-twice | percent | one tick is repeated, this share of a period after the first |
/// | reverse | | the spindle turns against its set-point |
/// | spindle-speed | r/min | the spindle runs away to this speed, in the sense of cutting |
/// | spindle-stop | | the spindle brakes to rest |
/// | z-offset | mm | measured Z is off by this much |
/// | u-block | | U stops moving |
/// | u-scale-stuck | | the reading of U's scale stops |
/// | u-reversed | | the force of U acts in the other direction |
/// | u-push | newton | a force on U, until another one |
/// | u-limit | -1, 0, 1 | the limit switch of U's lower end, none, that of its upper end is on |
/// | swing-block | | the swing of the tool stops moving |
/// | table-flip | byte | one bit of this byte of the table image flips in memory |
/// | stop | | the operator's stop command |
/// | hold | | ... hold of the feed |
/// | resume | | ... and its end |
/// | feed-override | percent | ... override of the feed |
/// | spindle-override | percent | ... of the spindle |
/// | trim | um | ... trim of X, on the radius |
/// | acknowledge | seconds | the operator presses the button acknowledge for this time |
/// | key | 0 or 1 | ... turns the key switch off or on |
/// | encoder-late | us | one frame of the encoder is late by this |
/// | encoder-missing | frames | this many frames of the encoder are not sent |
/// | encoder-repeated | frames | this many frames are replaced by the last one |
/// | encoder-swapped | pairs | this many pairs of frames are swapped |
/// | heartbeat-lost | node | the node with this number sends no more heartbeats |
/// | node-dead | node | it neither receives nor sends |
/// | node-fault | node | the drive with this number fails, with an emergency message |
///
/// Some work only in camsim run, some only in camsim bus, most in both.
#ifndef SIM_INJECT_H
#define SIM_INJECT_H

#include "common_error.h" // common_error_t
#include "sim_lathe.h"    // sim_lathe_t
#include <stdbool.h>      // bool
#include <stdint.h>       // uint32_t

typedef enum {
    sim_inject_estop,
    sim_inject_drive,
    sim_inject_bus,
    sim_inject_lost_counts,
    sim_inject_encoder_jump,
    sim_inject_encoder_stuck,
    sim_inject_encoder_rate,
    sim_inject_encoder_dither,
    sim_inject_index_dead,
    sim_inject_late_tick,
    sim_inject_clock_drift,
    sim_inject_tick_jitter,
    sim_inject_tick_burst,
    sim_inject_tick_twice,
    sim_inject_reverse,
    sim_inject_spindle_speed,
    sim_inject_spindle_stop,
    sim_inject_z_offset,
    sim_inject_u_block,
    sim_inject_u_scale_stuck,
    sim_inject_u_reversed,
    sim_inject_u_push,
    sim_inject_u_limit,
    sim_inject_swing_block,
    sim_inject_table_flip,
    sim_inject_stop,
    sim_inject_hold,
    sim_inject_resume,
    sim_inject_feed_override,
    sim_inject_spindle_override,
    sim_inject_trim,
    sim_inject_acknowledge,
    sim_inject_key,
    sim_inject_encoder_late,
    sim_inject_encoder_missing,
    sim_inject_encoder_repeated,
    sim_inject_encoder_swapped,
    sim_inject_heartbeat_lost,
    sim_inject_node_dead,
    sim_inject_node_fault,
    sim_n_injects
} sim_inject_kind_t;

/// Where a kind is possible. Only the live lathe has a button and a key switch.
typedef enum {
    sim_inject_in_run = 1,
    sim_inject_on_bus = 2,
    sim_inject_at_button = 4,
    sim_inject_in_live = sim_inject_in_run | sim_inject_at_button,
} sim_inject_place_t;

typedef struct {
    sim_inject_kind_t kind;
    double at_s;
    bool is_absolute; ///< at_s counts from the start of the run
    double value;
    bool is_done;
} sim_inject_t;

/// @param text   KIND@SECONDS[:VALUE] or KIND@tSECONDS[:VALUE]
/// @param place  where it is to happen
/// @return       false and *e when it is malformed or not possible there
bool sim_inject_parse(sim_inject_t *inject, const char *text, sim_inject_place_t place,
                      common_error_t *e);

/// @return the kind's name
const char *sim_inject_name(sim_inject_kind_t kind);

/// Apply an injection to the lathe; other kinds do nothing.
/// @param direction  +1 or -1: sense of cutting
void sim_inject_apply(const sim_inject_t *inject, sim_lathe_t *l, int direction);

// A simulated operator, who presses the button acknowledge when it is needed, or is
// absent.
//
// 0.3 s after the emergency-stop chain is closed and the fault is reset, the operator presses for
// 0.2 s, and again if that did not help. The operator turns the key switch for each new commander.

typedef struct {
    bool is_present;
    bool is_waiting; ///< the button is needed since since_s
    double since_s;
    double until_s;   ///< end of a press requested on stdin
    bool is_key_on;   ///< the key switch
    bool turns_key;   ///< off and on again for each new session
    uint32_t session; ///< at the last call
} sim_operator_t;

/// Press the button at once.
/// @param press_s  [s] duration
void sim_operator_press(sim_operator_t *o, double time_s, double press_s);

/// @param is_needed  the controller wants the button, the chain is closed, and no fault is latched
/// @param time_s     [s] rises from call to call
/// @return           whether the button is pressed
bool sim_operator_step(sim_operator_t *o, bool is_needed, double time_s);

/// @param session  of the commander, 0: nobody
/// @return         whether the key switch is on; it is off for one tick where a session is new
bool sim_operator_key(sim_operator_t *o, uint32_t session);

#endif
