// SPDX-License-Identifier: Apache-2.0
/// cam_rights: who may command the controller over a bus, and whether limits may be changed.
///
/// One sender has command. It took it, and got a session with it, a number that each of its frames
/// carries. Command that is not heard of for a second is lost; another one may take it over, and
/// both are counted. A bus has no secrets: whoever forges the frames of the commander commands. The
/// session keeps those apart who follow the rules, and tells the old commander that it is one no
/// more.
///
/// Limits, constants and tables change in the unlocked level only. A key switch that is turned on
/// while somebody has command, or the answer to a challenge unlocks for him; it ends with command,
/// by lock, and after ten minutes. A key that was left on is nothing to the next commander. The
/// secret of the challenge never crosses the bus.
///
/// This is about what comes over a bus. The program that calls cam_machine.h is trusted, as in a
/// run of the simulator or under LinuxCNC: it has command and is unlocked. All functions: slow
/// side, one caller; times are counted in ticks.
#ifndef CAM_RIGHTS_H
#define CAM_RIGHTS_H

#include "cam_err.h" // cam_err_t
#include "hal/hal.h" // hal_operator_t
#include <stdbool.h> // bool
#include <stdint.h>  // uint8_t, uint32_t

enum {
    cam_rights_patience_s = 1, ///< command is lost after this without a frame of its session
    cam_rights_level_s = 600,  ///< the level is locked again after this
    cam_rights_most_sender = 254,
};

/// Whether limits, constants and tables may be changed, and by what. The number is part of the CAN
/// protocol.
typedef enum { cam_level_locked, cam_level_key, cam_level_challenge } cam_level_t;

/// State; made by cam_rights_init().
typedef struct {
    hal_operator_t port; ///< what there is for an operator
    uint32_t tick_hz;
    bool is_bus_calling;   ///< what is carried out was commanded over a bus (cam_can.c)
    uint8_t commander;     ///< its sender number, 0: nobody
    uint8_t session;       ///< of the commander, or the last one
    uint32_t heard_tick;   ///< [ticks] of its last frame
    uint32_t n_take_overs; ///< times that command was taken over from another
    uint32_t n_losses;     ///< times that command was lost
    cam_level_t level;
    uint32_t level_tick;     ///< [ticks] when it was unlocked
    bool is_key_on;          ///< key switch at the last look
    bool is_challenged;      ///< the challenge waits for its answer
    uint32_t challenge;      ///< the last one
    uint32_t challenge_tick; ///< [ticks] when it was given
    uint64_t noise;          ///< of the moments in which the commander was heard
} cam_rights_t;

/// Begin: nobody has command, and the level is locked.
void cam_rights_init(cam_rights_t *r, const hal_operator_t *port, uint32_t tick_hz);

/// Take command with a new session.
/// @param sender   1 .. cam_rights_most_sender
/// @param is_over  even if somebody has it
/// @return cam_ok; cam_err_not_commander when somebody has it; cam_err_frame for another sender
CAM_MUST_USE cam_err_t cam_rights_take(cam_rights_t *r, uint8_t sender, bool is_over,
                                       uint32_t tick);

/// Give command up. The level is locked.
void cam_rights_release(cam_rights_t *r);

/// @return whether a frame is of the session in force
bool cam_rights_is_commander(const cam_rights_t *r, uint8_t sender, uint8_t session);

/// The commander was heard.
void cam_rights_hear(cam_rights_t *r, uint32_t tick);

/// Ask for a challenge. The answer is made of it by whoever knows the secret of the port, so that
/// what was overheard on the bus is worth nothing.
/// @param challenge  result
/// @return cam_ok; cam_err_busy within a second of the last one; cam_err_locked or
/// cam_err_lock_none
///         when the port has no secret
CAM_MUST_USE cam_err_t cam_rights_challenge(cam_rights_t *r, uint32_t tick, uint32_t *challenge);

/// Answer the last challenge, which is used up by it: it unlocks the level.
/// @param answer  first four bytes, the lowest first, of BLAKE2b-512 keyed with the secret, of the
///                challenge as four bytes, the lowest first
/// @return cam_ok, cam_err_unlock
CAM_MUST_USE cam_err_t cam_rights_unlock(cam_rights_t *r, uint32_t answer, uint32_t tick);

/// Lock the level; the key switch unlocks it again when it is turned anew.
void cam_rights_lock(cam_rights_t *r);

/// Let time pass.
/// @param inputs  hal_in_* of the last tick
/// @return        whether command was lost since the last call
bool cam_rights_poll(cam_rights_t *r, uint32_t inputs, uint32_t tick);

/// @return cam_ok in the unlocked level; else cam_err_locked, or cam_err_lock_none when this port
///         never has it
CAM_MUST_USE cam_err_t cam_rights_check_level(const cam_rights_t *r);

/// @return [s] until the level is locked again, rounded up; 0 when it is
uint32_t cam_rights_level_left_s(const cam_rights_t *r, uint32_t tick);

#endif
