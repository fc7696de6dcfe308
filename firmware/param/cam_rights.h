// SPDX-License-Identifier: Apache-2.0
/// cam_rights: command over a bus, and the level at which limits may be changed.
///
/// One sender at a time has command. Taking command starts a session, a number that each of the
/// sender's frames carries. After a second without such a frame, command is lost; another sender
/// may also take it over. Both are counted. The session separates senders that follow the rules and
/// shows a former commander that it no longer has command; it does not protect against forged
/// frames.
///
/// Limits, constants and tables change in the unlocked level only. The commander gets it when the
/// key switch is turned on or by answering a challenge, whose secret never crosses the bus. It ends
/// with command, with lock, and after ten minutes. A key left on does not unlock for the next
/// commander.
///
/// A program that calls cam_machine.h directly (simulator, LinuxCNC) is trusted: it has command and
/// is unlocked. All functions: slow side, one caller; times are counted in ticks.
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

/// Level, and what unlocked it. The number is part of the CAN protocol.
typedef enum { cam_level_locked, cam_level_key, cam_level_challenge } cam_level_t;

/// State; made by cam_rights_init().
typedef struct {
    hal_operator_t port; ///< key switch, secret and button of the port
    uint32_t tick_hz;
    bool is_bus_calling;   ///< the call being handled came over a bus (cam_can.c)
    uint8_t commander;     ///< its sender number; 0: nobody
    uint8_t session;       ///< of the commander, or the last one
    uint32_t heard_tick;   ///< [ticks] of its last frame
    uint32_t n_take_overs; ///< take-overs of command
    uint32_t n_losses;     ///< losses of command
    cam_level_t level;
    uint32_t level_tick;     ///< [ticks] when it was unlocked
    bool is_key_on;          ///< key switch at the last poll
    bool is_challenged;      ///< the challenge awaits its answer
    uint32_t challenge;      ///< the last one
    uint32_t challenge_tick; ///< [ticks] when it was given
    uint64_t noise;          ///< from the times of the commander's frames
} cam_rights_t;

/// Begin: nobody has command, and the level is locked.
void cam_rights_init(cam_rights_t *r, const hal_operator_t *port, uint32_t tick_hz);

/// Take command with a new session.
/// @param sender   1 .. cam_rights_most_sender
/// @param is_over  take it over if another sender has it
/// @return cam_ok; cam_err_not_commander if another sender has it; cam_err_frame: sender invalid
CAM_MUST_USE cam_err_t cam_rights_take(cam_rights_t *r, uint8_t sender, bool is_over,
                                       uint32_t tick);

/// Release command and lock the level.
void cam_rights_release(cam_rights_t *r);

/// @return whether a frame belongs to the current session
bool cam_rights_is_commander(const cam_rights_t *r, uint8_t sender, uint8_t session);

/// Note a frame of the commander.
void cam_rights_hear(cam_rights_t *r, uint32_t tick);

/// Make a challenge. Its answer needs the port's secret, so an overheard answer is useless.
/// @param challenge  result
/// @return cam_ok; cam_err_busy within a second of the last one; without a secret cam_err_locked
///         (the port has a key switch) or cam_err_lock_none
CAM_MUST_USE cam_err_t cam_rights_challenge(cam_rights_t *r, uint32_t tick, uint32_t *challenge);

/// Unlock the level by the answer to the last challenge, which is void afterwards.
/// @param answer  first four bytes, the lowest first, of BLAKE2b-512 keyed with the secret, of the
///                challenge as four bytes, the lowest first
/// @return cam_ok, cam_err_unlock
CAM_MUST_USE cam_err_t cam_rights_unlock(cam_rights_t *r, uint32_t answer, uint32_t tick);

/// Lock the level; turning the key switch on again unlocks it.
void cam_rights_lock(cam_rights_t *r);

/// Update command and level from time and key switch.
/// @param inputs  hal_in_* of the last tick
/// @return        whether command was lost since the last call
bool cam_rights_poll(cam_rights_t *r, uint32_t inputs, uint32_t tick);

/// @return cam_ok in the unlocked level; else cam_err_locked, or cam_err_lock_none if this port
///         cannot unlock
CAM_MUST_USE cam_err_t cam_rights_check_level(const cam_rights_t *r);

/// @return [s] until the level is locked again, rounded up; 0: locked
uint32_t cam_rights_level_left_s(const cam_rights_t *r, uint32_t tick);

#endif
