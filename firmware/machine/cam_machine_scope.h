// SPDX-License-Identifier: Apache-2.0
/// cam_machine_scope: who has the recorder and its memory.
///
///     nobody -> black box (cam_blackbox.h), when cam_machine_blackbox() asked for it
///     black box -> recording, wave: by command at any time, as long as no fault was recorded
///     black box of a fault: stays, over further faults and restarts, until cam_machine_release()
///     recording, wave -> black box: by cam_machine_release(), or cam_scope_patience_s after its
///     end
///
/// So a command takes the memory from the black box, which is empty when it comes back, and is
/// refused with cam_err_scope_unread where that would destroy what a fault has left. An excitation
/// takes the memory from a recording that is done, and is refused with cam_err_scope_on while one
/// runs. Context: slow side, one caller.
#ifndef CAM_MACHINE_SCOPE_H
#define CAM_MACHINE_SCOPE_H

#include "cam_machine.h" // cam_machine_t
#include <stdint.h>      // int32_t, uint32_t

/// [s] that a recording keeps the memory from the black box when nobody releases it.
enum { cam_scope_patience_s = 600 };

/// Let the recorder be the black box from now on, with the box that the port has kept. A loop that
/// takes the records of the ticks itself does without.
void cam_machine_blackbox(cam_machine_t *m);

/// @return cam_ok when a command may take the memory; cam_err_scope_on, cam_err_scope_unread
CAM_MUST_USE cam_err_t cam_machine_scope_is_free(const cam_machine_t *m);

/// Begin a recording, in place of one that runs. @return as cam_scope_start();
/// cam_err_scope_trace; cam_err_scope_unread; cam_err_state, while an excitation runs
CAM_MUST_USE cam_err_t cam_machine_scope_start(cam_machine_t *m);

/// End the recording that was asked for; the black box goes on.
void cam_machine_scope_stop(cam_machine_t *m);

/// Give recording, wave or the box of a fault up: the black box begins anew.
/// @return cam_ok, or cam_err_state while an excitation runs
CAM_MUST_USE cam_err_t cam_machine_release(cam_machine_t *m);

/// Set a field of the recorder. @return as cam_scope_set()
CAM_MUST_USE cam_err_t cam_machine_scope_set(cam_machine_t *m, uint32_t field, int32_t value);

/// Read a field of the recorder. @return as cam_scope_get()
CAM_MUST_USE cam_err_t cam_machine_scope_get(const cam_machine_t *m, uint32_t field,
                                             int32_t *value);

/// Ask for a sample of single ticks, message Strobe, or ask again (cam_strobe.h).
/// @param every  [ticks] between samples; 0: no more
/// @return       cam_ok; cam_err_param_range, below cam_strobe_least() or above the tick rate;
///               cam_err_scope_trace
CAM_MUST_USE cam_err_t cam_machine_strobe(cam_machine_t *m, uint32_t every);

/// Hand a record of the trace ring to all who want it, in the order of the ticks. For a loop that
/// reads the ring itself.
void cam_machine_record(cam_machine_t *m, const cam_tick_record_t *r);

/// The part of cam_machine_poll() that reads the trace ring, as long as a recording or a live
/// picture waits for its records; else they stay there. To be called at least every
/// cam_trace_capacity / 2 ticks meanwhile.
void cam_machine_scope_poll(cam_machine_t *m);

#endif
