// SPDX-License-Identifier: Apache-2.0
/// fuzz_rig: the controller with an ideal machine around hal/host, in whole numbers, so that a tick
/// costs little. A start of the rig is made once and then copied back before every input.
#ifndef FUZZ_RIG_H
#define FUZZ_RIG_H

#include "cam_can.h"     // cam_can_t
#include "cam_machine.h" // cam_machine_t
#include "fuzz_judge.h"  // fuzz_judge_t
#include <stdbool.h>     // bool
#include <stdint.h>      // int32_t, int64_t

/// What a rig begins with.
typedef struct {
    uint32_t tick_hz;
    uint32_t part;     ///< below fuzz_rig_n_parts
    cam_state_t state; ///< off, ready, cutting or manual
    bool has_button;   ///< the button acknowledge is wired, and was pressed for a state but off
} fuzz_start_t;

enum { fuzz_rig_n_parts = 3 }; ///< the short skirt, the modulated skirt, the camshaft
enum { fuzz_rig_n_rates = 8 }; ///< from 500 Hz to 100 kHz

/// What an axis has to be homed by.
typedef struct {
    int32_t side;     ///< +1: the switch is active from its edge upwards, -1: downwards, 0: none
    int32_t edge_nm;  ///< [nm]
    int32_t pitch_nm; ///< [nm] from index to index; 0: none
    uint32_t n_seen;  ///< [ticks] for which the last index is still shown
} fuzz_home_t;

typedef struct {
    cam_machine_t machine;
    cam_can_t can;
    int64_t pos_q32;              ///< [turn / 2^32] spindle, of the encoder's counts
    int64_t speed_q32;            ///< [turn / 2^32 per tick]
    int64_t ramp_q32;             ///< largest change of it per tick
    int32_t counts_per_turn;      ///< of the encoder
    bool is_spindle_held;         ///< the speed stays as the target sets it
    bool is_held[hal_n_axes];     ///< the measured axis stays where it is
    int32_t error_nm[hal_n_axes]; ///< [nm] added to what is measured
    bool is_swing_held;           ///< ... of the swing
    uint32_t n_swing;             ///< set-points of the swing that have been followed
    fuzz_home_t home[hal_n_axes]; ///< switches and indices
    fuzz_judge_t judge;           ///< asked after every tick
} fuzz_rig_t;

extern fuzz_rig_t fuzz_rig;

/// A command may be refused: what the judge finds is all that counts.
static inline void fuzz_try(cam_err_t err)
{
    (void)err;
}

/// @return [Hz] a tick rate
uint32_t fuzz_rig_hz(uint32_t rate);

/// Bring the rig to a start, from a copy when it was there before.
void fuzz_rig_start(fuzz_start_t start);

/// @return whether everything is told, to understand what was found: CAM_FUZZ_TRACE=1
bool fuzz_rig_is_traced(void);

/// One tick and the judge's verdict on it.
void fuzz_rig_tick(void);

/// n times what main() does in its loop.
void fuzz_rig_loop(uint32_t n);

/// Press the button acknowledge for n ticks, with an eighth of a second before and behind it.
void fuzz_rig_press(uint32_t n);

/// @return the record of the newest tick
const cam_tick_record_t *fuzz_rig_record(void);

/// @return the state of the newest tick
cam_state_t fuzz_rig_state(void);

/// @return the image of a part
const void *fuzz_rig_image(uint32_t part, size_t *size);

/// Take a table into use that the target owns, in state off.
cam_err_t fuzz_rig_select(const void *image, size_t size);

#endif
