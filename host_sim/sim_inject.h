// SPDX-License-Identifier: Apache-2.0
/// sim_inject: what goes wrong, and when: KIND@SECONDS[:VALUE].
///
/// SECONDS count from the first tick of the cutting state, or from the start of time when written
/// tSECONDS. Each happens once.
///
/// | kind | value | what happens |
/// |---|---|---|
/// | estop | | the emergency-stop chain opens |
/// | drive | | the drives report that they are not ready |
/// | bus | | a node on the bus goes silent, the drives are still heard |
/// | lost-counts | counts | the encoder loses that many |
/// | encoder-jump | counts | the encoder gains that many |
/// | encoder-stuck | | the counter stands still |
/// | index-dead | | no more index edges |
/// | late-tick | percent | one tick comes late by this much of a period |
/// | reverse | | the spindle turns against its set-point |
/// | spindle-speed | r/min | the spindle runs away to that speed, in the sense of cutting |
/// | spindle-stop | | the spindle brakes to rest |
/// | z-offset | mm | measured Z is off by this much |
/// | u-block | | U stands still |
/// | table-flip | byte | one bit of that byte of the table image flips in memory |
/// | stop | | the operator's stop command |
#ifndef SIM_INJECT_H
#define SIM_INJECT_H

#include "sim_error.h"   // sim_error_t
#include "sim_machine.h" // sim_machine_t
#include <stdbool.h>     // bool

typedef enum {
    sim_inject_estop,
    sim_inject_drive,
    sim_inject_bus,
    sim_inject_lost_counts,
    sim_inject_encoder_jump,
    sim_inject_encoder_stuck,
    sim_inject_index_dead,
    sim_inject_late_tick,
    sim_inject_reverse,
    sim_inject_spindle_speed,
    sim_inject_spindle_stop,
    sim_inject_z_offset,
    sim_inject_u_block,
    sim_inject_table_flip,
    sim_inject_stop,
    sim_n_injects
} sim_inject_kind_t;

typedef struct {
    sim_inject_kind_t kind;
    double at_s;
    bool is_absolute; ///< at_s counts from the start of time
    double value;
    bool is_done;
} sim_inject_t;

/// @param text  KIND@SECONDS[:VALUE] or KIND@tSECONDS[:VALUE]
/// @return      false and *e when it is malformed
bool sim_inject_parse(sim_inject_t *inject, const char *text, sim_error_t *e);

/// @return the kind's name
const char *sim_inject_name(sim_inject_kind_t kind);

/// Do to the machine what the kind says. table-flip and stop are not the machine's: nothing
/// happens. Call between sense and advance.
/// @param direction  +1 or -1: sense of cutting
void sim_inject_apply(const sim_inject_t *inject, sim_machine_t *m, int direction);

#endif
