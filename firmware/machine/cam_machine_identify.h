// SPDX-License-Identifier: Apache-2.0
/// cam_machine_identify: excitation of U by a downloaded wave, for identification.
///
///     wave_begin -> wave_block, .. -> wave_end -> excite, keep_alive, .. -> state ready again
///
/// The samples are int32 [nm], one per tick, of one period; they lie at the begin of the recorder's
/// memory (cam_scope.h), so that a new wave ends what was recorded. An excitation is judged before
/// it begins: length, stroke, speed and acceleration with the wrap and the fade (cam_wave.h), and X
/// must be so far out that the tool stays off the work by half the clearance. It records by itself:
/// what the recorder's fields ask for, from the first tick of the state identifying to the last.
///
/// While the state is identifying a sign of life is needed every cam_identify_patience_ms, else U
/// is brought to rest. So it is by stop and by disable, which takes the enable away afterwards; a
/// fault retracts U as always. The guard allows the following error its limit and the largest
/// sample, because the wave has no feed-forward. Context: slow side, one caller.
#ifndef CAM_MACHINE_IDENTIFY_H
#define CAM_MACHINE_IDENTIFY_H

#include "cam_machine.h" // cam_machine_t
#include "cam_wave.h"    // cam_wave_verdict_t
#include <stdint.h>      // uint8_t, uint32_t

enum { cam_identify_patience_ms = 500 };

/// Begin the download of a wave. The wave and the recording that are there are lost.
/// @param n_bytes  [bytes] a multiple of 4
/// @return         cam_ok; cam_err_state, cam_err_busy while an excitation runs; cam_err_scope_on,
///                 cam_err_scope_unread (cam_machine_scope.h); cam_err_wave_length;
///                 cam_err_scope_memory (more than half of it)
CAM_MUST_USE cam_err_t cam_machine_wave_begin(cam_machine_t *m, uint32_t n_bytes);

/// Store the next bytes. Bytes that are there already, and the same, are accepted again.
/// @param n  [bytes] a multiple of 4
/// @return   cam_ok; cam_err_download_order: go on at cam_machine_wave_received();
///           cam_err_download_room: beyond the announced size
CAM_MUST_USE cam_err_t cam_machine_wave_block(cam_machine_t *m, uint32_t offset,
                                              const uint8_t *bytes, uint32_t n);

/// @return [bytes] of the wave that are there
uint32_t cam_machine_wave_received(const cam_machine_t *m);

/// End the download.
/// @param crc  CRC-32 of all bytes
/// @return     cam_ok: excite plays it; cam_err_download_order, _short: it may go on;
///             cam_err_download_crc: it has to begin anew
CAM_MUST_USE cam_err_t cam_machine_wave_end(cam_machine_t *m, uint32_t crc);

/// Play the wave: ready -> identifying -> ready.
/// @param n_periods   at full gain, 1 .. as cam_wave_longest_s allows
/// @param fade_ticks  [ticks] in which it rises, and falls
/// @return            cam_ok, cam_err_state, _busy, _wave_none, _scope_trace, _scope_memory,
///                    _scope_unread, or a verdict of cam_wave_judge(); cam_err_wave_clear with the
///                    X [nm] that is needed
cam_wave_verdict_t cam_machine_excite(cam_machine_t *m, uint32_t n_periods, uint32_t fade_ticks);

/// A sign of life of whoever commands the excitation, or moves an axis by hand.
void cam_machine_keep_alive(cam_machine_t *m);

/// The part of cam_machine_poll() that leads the excitation.
void cam_machine_identify_poll(cam_machine_t *m);

/// Stop or disable in the state identifying. @return cam_ok, cam_err_busy
CAM_MUST_USE cam_err_t cam_machine_identify_stop(cam_machine_t *m, bool disables);

#endif
