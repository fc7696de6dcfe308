// SPDX-License-Identifier: Apache-2.0
/// cam_machine_scope: owner of the recorder and its memory.
///
///     free -> black box (cam_blackbox.h): once cam_machine_blackbox() was called
///     black box -> recording, wave: by command, unless the box holds a fault
///     black box with a fault: stays, through faults and restarts, until cam_machine_release()
///     recording, wave -> black box: by cam_machine_release(), or cam_scope_patience_s after its
///     end
///
/// A command discards the black box, but is refused with cam_err_scope_unread when the box holds a
/// fault. An excitation discards a finished recording, but is refused with cam_err_scope_on during
/// one. Context: slow side, one caller.
#ifndef CAM_MACHINE_SCOPE_H
#define CAM_MACHINE_SCOPE_H

#include "cam_machine.h" // cam_machine_t
#include <stdint.h>      // int32_t, uint32_t

/// [s] until the black box replaces a finished recording that nobody releases.
enum { cam_scope_patience_s = 600 };

/// Use the recorder as black box, starting with the box saved by the port. Not for a loop that
/// reads the trace ring itself.
void cam_machine_blackbox(cam_machine_t *m);

/// Start a recording; replaces a running one. @return as cam_scope_begin();
/// cam_err_scope_unread; cam_err_state during an excitation
CAM_MUST_USE cam_err_t cam_machine_scope_start(cam_machine_t *m);

/// Stop the commanded recording. The black box continues.
void cam_machine_scope_stop(cam_machine_t *m);

/// Discard recording, wave or the box of a fault: the black box starts again.
/// @return cam_ok, or cam_err_state during an excitation
CAM_MUST_USE cam_err_t cam_machine_release(cam_machine_t *m);

/// Set a field of the recorder. @return as cam_scope_set()
CAM_MUST_USE cam_err_t cam_machine_scope_set(cam_machine_t *m, uint32_t field, int32_t value);

/// Read a field of the recorder. @return as cam_scope_get()
CAM_MUST_USE cam_err_t cam_machine_scope_get(const cam_machine_t *m, uint32_t field,
                                             int32_t *value);

/// Subscribe to samples of single ticks, message Strobe, or renew (cam_strobe.h).
/// @param every  [ticks] between samples; 0: unsubscribe
/// @return       cam_ok; cam_err_param_range, below cam_strobe_least() or above the tick rate
CAM_MUST_USE cam_err_t cam_machine_strobe(cam_machine_t *m, uint32_t every);

/// Pass a record of the trace ring to recorder and strobe, in the order of the ticks. For a loop
/// that reads the ring itself.
void cam_machine_record(cam_machine_t *m, const cam_tick_record_t *r);

/// Part of cam_machine_poll(): read the trace ring for a recording or a strobe, and run the black
/// box. Call at least every cam_trace_capacity / 2 ticks while either is on.
void cam_machine_scope_poll(cam_machine_t *m);

#endif
