// SPDX-License-Identifier: Apache-2.0
/// cam_identify: state of the excitation of U on the slow side; the functions are those of
/// cam_machine_identify.h.
#ifndef CAM_IDENTIFY_H
#define CAM_IDENTIFY_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// What came of the last excitation. The number is part of the CAN protocol.
typedef enum {
    cam_excited_never,
    cam_excited_runs,    ///< it has not ended
    cam_excited_done,    ///< played to its end
    cam_excited_stopped, ///< cut short by stop or disable
    cam_excited_silent,  ///< cut short because no sign of life came
    cam_excited_fault,   ///< cut short by a fault, or the interrupt did not begin it
} cam_excited_t;

/// How far an excitation has got.
typedef enum {
    cam_identify_none,
    cam_identify_offered,   ///< the interrupt has still to take the wave
    cam_identify_requested, ///< ... and to begin
    cam_identify_runs,
    cam_identify_ends, ///< the interrupt has still to be given a configuration without the wave
} cam_identify_phase_t;

/// State; zero-initialised is without a wave.
typedef struct {
    uint32_t n_bytes;  ///< [bytes] of the wave that is downloaded
    uint32_t received; ///< [bytes] of it that are there
    bool is_open;      ///< blocks are accepted
    uint32_t n;        ///< [samples] of the complete wave; 0: none
    int32_t place_nm;  ///< [nm] of U, about which it is played
    uint32_t n_fall;   ///< [ticks] at the end of the last excitation in which its gain falls
    cam_identify_phase_t phase;
    cam_excited_t excited;
    int32_t following_nm; ///< [nm] limit of the following error that comes back at the end
    uint32_t alive_tick;  ///< when the last sign of life came
    bool disables;        ///< disable as soon as the excitation has ended
} cam_identify_t;

/// @return whether the state of the machine may be about to change
static inline bool cam_identify_is_between(const cam_identify_t *i)
{
    return i->phase != cam_identify_none && i->phase != cam_identify_runs;
}

#endif
