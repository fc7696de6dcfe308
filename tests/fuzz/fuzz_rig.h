// SPDX-License-Identifier: Apache-2.0
/// fuzz_rig: the controller on the ideal machine. A start of the rig is made once and then copied
/// back before every input.
#ifndef FUZZ_RIG_H
#define FUZZ_RIG_H

#include "cam_remote.h"    // cam_can_t
#include "cam_machine.h"   // cam_machine_t
#include "fuzz_digest.h"   // fuzz_note
#include "fuzz_judge.h"    // fuzz_judge_t
#include "ideal_machine.h" // ideal_machine_t
#include <stdbool.h>       // bool
#include <stdint.h>        // uint32_t

/// What a rig begins with.
typedef struct {
    uint32_t tick_hz;
    uint32_t part;     ///< below fuzz_rig_n_parts
    cam_state_t state; ///< off, ready, cutting or manual
    bool has_button;   ///< the button acknowledge is wired, and was pressed for a state but off
    bool takes_force;  ///< U takes forces, from a loop that is weak, as the axes need none
} fuzz_start_t;

enum { fuzz_rig_n_parts = 4 }; ///< short skirt, modulated skirt, camshaft, skirt with stations
enum { fuzz_rig_n_rates = 8 }; ///< from 500 Hz to 100 kHz

typedef struct {
    cam_machine_t machine;
    cam_can_t can;
    ideal_machine_t lathe; ///< its drives lag as the parameters state
    fuzz_judge_t judge;    ///< asked after every tick
} fuzz_rig_t;

extern fuzz_rig_t fuzz_rig;

/// Give a command that may be refused; the digest gets the result, the judge does not.
static inline void fuzz_try(cam_err_t err)
{
    fuzz_note(err);
}

/// The same for a command whose answer has a number.
static inline void fuzz_try_verdict(cam_verdict_t verdict)
{
    fuzz_try(verdict.err);
    fuzz_note(verdict.value);
}

/// @return [Hz] a tick rate
uint32_t fuzz_rig_hz(uint32_t rate);

/// @param how  from its lowest bits up: a rate from 1 to 20 kHz, the state, other things
/// @return     with the short skirt, without a button and forces
fuzz_start_t fuzz_rig_start_of(uint8_t how);

/// Another encoder, before the spindle turns. It stands at its index, so that the next edge comes
/// after a whole turn, with the spindle at speed.
void fuzz_rig_encoder(int32_t counts_per_turn);

/// Bring the rig to a start, from a copy when it was there before.
void fuzz_rig_start(fuzz_start_t start);

/// @return whether draws and ticks are printed, to understand a finding: CAM_FUZZ_TRACE=1
bool fuzz_rig_is_traced(void);

/// One tick, the judge's verdict on it, and the ranges of the proof (tests/proof), within which its
/// state must be.
void fuzz_rig_tick(void);

/// Check and note every member of a configuration against the ranges of the proof.
void fuzz_rig_walk_config(cam_config_t *config);

/// n times what main() does in its loop.
void fuzz_rig_loop(uint32_t n);

/// @return the record of the newest tick
const cam_tick_record_t *fuzz_rig_record(void);

/// @return the state of the newest tick
cam_state_t fuzz_rig_state(void);

/// @return the image of a part
const void *fuzz_rig_image(uint32_t part, size_t *size);

/// Take a table into use that the target owns, in state off.
cam_err_t fuzz_rig_select(const void *image, size_t size);

#endif
