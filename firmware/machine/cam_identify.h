// SPDX-License-Identifier: Apache-2.0
/// cam_identify: state of the excitation of U on the slow side (cam_machine_identify.h).
#ifndef CAM_IDENTIFY_H
#define CAM_IDENTIFY_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t

/// Result of the last excitation. The numbers are part of the CAN protocol.
typedef enum {
    cam_excited_never,
    cam_excited_runs,
    cam_excited_done,    ///< played to its end
    cam_excited_stopped, ///< by stop or disable
    cam_excited_silent,  ///< stopped for lack of a sign of life
    cam_excited_fault,   ///< stopped by a fault, or refused by the interrupt
} cam_excited_t;

/// Phase of an excitation.
typedef enum {
    cam_identify_none,
    cam_identify_offered,   ///< the interrupt has not yet taken the wave
    cam_identify_requested, ///< the interrupt has not yet started
    cam_identify_runs,
    cam_identify_ends, ///< the configuration without the wave is not yet offered
} cam_identify_phase_t;

/// State; zero-initialised: no wave.
typedef struct {
    uint32_t n_bytes;  ///< [bytes] announced size of the download
    uint32_t received; ///< [bytes]
    bool is_open;      ///< blocks are accepted
    uint32_t n;        ///< [samples] of the complete wave; 0: none
    int32_t place_nm;  ///< [nm] U's mean position
    uint32_t n_fall;   ///< [ticks] in which the gain falls at the end
    cam_identify_phase_t phase;
    cam_excited_t excited;
    int32_t following_nm; ///< [nm] limit of the following error, restored at the end
    uint32_t alive_tick;  ///< [tick] of the last sign of life
    bool disables;        ///< disable the drives at the end
} cam_identify_t;

/// @return whether the state of the machine may be about to change
static inline bool cam_identify_is_between(const cam_identify_t *i)
{
    return i->phase != cam_identify_none && i->phase != cam_identify_runs;
}

#endif
