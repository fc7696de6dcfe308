// SPDX-License-Identifier: Apache-2.0
/// cam_machine_identify: excitation of U by a downloaded wave, for identification.
///
///     wave_begin -> wave_block, .. -> wave_end -> excite, keep_alive, .. -> state ready again
///
/// The samples are int32 [nm], one per tick, of one period, or [mN] of force where the field
/// wave_unit is set to 1 after wave_begin. They occupy the start of the recorder's memory
/// (cam_scope.h), so that a new wave discards the recording. Before it starts, an excitation is
/// checked for length, stroke, speed and acceleration, with the wrap and the fade (cam_wave.h), and
/// for half the clearance between tool and work. The recorder records it, with the columns set
/// before, from the first tick of the state identifying to the last.
///
/// A wave of force is added to the force of U's position loop, which stays closed. At a crossover
/// of 1 Hz U moves as the wave alone would move it; with the loop of the cut the wave measures that
/// loop. The wave must stay within the force limit, the position about which it plays within the
/// stroke, and X clear of all of U's travel; a following error of that travel is accepted, and the
/// supervision of the force (cam_force.h) continues. The record shows the force of a sample in the
/// next tick. At its end the force drops to 0 at once, and the usual limit of the following error
/// applies again.
///
/// Without a sign of life for cam_identify_patience_ms U is brought to rest; stop and disable do
/// the same, and disable then disables the drives. The wave has no feed-forward, so the guard
/// allows a following error of its limit plus the largest sample, or that of a motion by time if
/// that is larger. Context: slow side, one caller.
#ifndef CAM_MACHINE_IDENTIFY_H
#define CAM_MACHINE_IDENTIFY_H

#include "cam_err.h"     // cam_verdict_t
#include "cam_machine.h" // cam_machine_t
#include <stdint.h>      // uint8_t, uint32_t

enum { cam_identify_patience_ms = 500 };

/// Begin the download of a wave. The present wave and recording are lost.
/// @param n_bytes  [bytes] a multiple of 4
/// @return         cam_ok; cam_err_state, cam_err_busy while an excitation runs; cam_err_scope_on,
///                 cam_err_scope_unread (cam_machine_scope.h); cam_err_wave_length;
///                 cam_err_scope_memory (more than half of it)
CAM_MUST_USE cam_err_t cam_machine_wave_begin(cam_machine_t *m, uint32_t n_bytes);

/// Store the next bytes. Accepts a repetition of bytes already received.
/// @param n  [bytes] a multiple of 4
/// @return   cam_ok; cam_err_download_order: continue at m->identify.received;
///           cam_err_download_room: beyond the announced size
CAM_MUST_USE cam_err_t cam_machine_wave_block(cam_machine_t *m, uint32_t offset,
                                              const uint8_t *bytes, uint32_t n);

/// End the download.
/// @param crc  CRC-32 of all bytes
/// @return     cam_ok: the wave can be played; cam_err_download_order, _short: the download may
///             continue; cam_err_download_crc: it must start again
CAM_MUST_USE cam_err_t cam_machine_wave_end(cam_machine_t *m, uint32_t crc);

/// Play the wave: ready -> identifying -> ready.
/// @param n_periods   at full gain, at least 1; cam_wave_longest_s limits them
/// @param fade_ticks  [ticks] of the rise, and of the fall
/// @return            cam_ok, cam_err_state, _busy, _wave_none, _scope_memory, _scope_unread,
///                    or a verdict of cam_wave_judge(), cam_wave_judge_force();
///                    cam_err_wave_clear with the required X [nm]
cam_verdict_t cam_machine_excite(cam_machine_t *m, uint32_t n_periods, uint32_t fade_ticks);

/// Part of cam_machine_poll(): the sequence of the excitation.
void cam_machine_identify_poll(cam_machine_t *m);

/// Stop or disable in the state identifying. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_identify_stop(cam_machine_t *m, bool disables);

#endif
