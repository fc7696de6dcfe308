// SPDX-License-Identifier: Apache-2.0
/// cam_machine_inner: interface between the files cam_machine_*.c, private to this folder.
///
/// One request and one configuration can be pending; until the interrupt has taken it, the next is
/// refused with cam_err_busy.
/// Context: slow side, one caller.
#ifndef CAM_MACHINE_INNER_H
#define CAM_MACHINE_INNER_H

#include "cam_machine.h" // cam_machine_t
#include <stdbool.h>     // bool
#include <stdint.h>      // uint32_t

/// @return the newest configuration handed over, in force or about to be; NULL before the first
static inline const cam_config_t *cam_machine_newest_config(const cam_machine_t *m)
{
    return atomic_load_explicit(&m->core->config.offered, memory_order_relaxed);
}

/// Where the spindle turns more slowly, the observer follows its ripple better than 256 points do:
/// it misses (n / f)^2 of it at n turns/s and a bandwidth f, and they (2 pi / 256)^2.
/// @return [r/min / 1000] speed from which the ripple is learned: f / 32 turns per second
uint32_t cam_machine_ripple_from_mrpm(const cam_params_t *params);

/// @return whether the interrupt has carried out the last request
bool cam_machine_is_carried_out(const cam_machine_t *m, const cam_status_t *status);

/// @return whether the state may be about to change: a request is not carried out, or an excitation
///         is between two steps
bool cam_machine_is_pending(const cam_machine_t *m, const cam_status_t *status);

/// Post a request unchecked. The caller has checked that the last one is carried out.
void cam_machine_request(cam_machine_t *m, cam_request_t request);

/// Post a request to the interrupt, which takes it in the next tick.
/// @return cam_ok, or cam_err_busy if cam_machine_is_pending()
CAM_MUST_USE cam_err_t cam_machine_post(cam_machine_t *m, const cam_status_t *status,
                                        cam_request_t request);

/// Check the inputs, that U's position loop is set, and that U is within its stroke: set-points are
/// limited to the stroke, so U would jump to its edge on enable.
/// @return cam_ok, cam_err_estop, _drive, _bus, _servo_none, _u_place
CAM_MUST_USE cam_err_t cam_machine_check_drives(const cam_params_t *params,
                                                const cam_status_t *status);

/// @return cam_ok when the button was pressed or is waived; else cam_err_acknowledge, or
///         cam_err_acknowledge_none when the port has no button
CAM_MUST_USE cam_err_t cam_machine_check_acknowledge(const cam_machine_t *m,
                                                     const cam_status_t *status);

/// Stop the motion when command is lost. Part of cam_machine_poll().
void cam_machine_rights_poll(cam_machine_t *m, const cam_status_t *status);

/// @return the configuration of the acknowledge button
cam_acknowledge_config_t cam_machine_acknowledge_config(const cam_machine_t *m);

/// Check all passes at the speeds that start would use. If infeasible, record why in m->refusal.
/// @return cam_ok or a feasibility error
CAM_MUST_USE cam_err_t cam_machine_judge(cam_machine_t *m, const cam_params_t *params,
                                         const cam_table_t *table);

/// @return the defaults of this port, with learning on where U is measured
cam_params_t cam_machine_defaults(uint32_t tick_hz);

/// Hand over the kept parameters if they are undamaged and fit the tick.
/// Context: before the tick starts.
/// @return false when nothing was handed over, see m->kept.err
bool cam_machine_load_params(cam_machine_t *m);

/// Offer the copy from cam_config_copy(), changed, with a new generation; in force from the next
/// tick on. The rest of the configuration is not checked again. The sums of configured and learned
/// k1 and k2 must be below 2^31.
void cam_machine_offer_copy(cam_machine_t *m);

/// Hand parameters, table and learned values to the interrupt as the configuration of one pass,
/// with the parameters of cam_pass_params(). The overspeed limit is 1 % above the peak that the
/// highest feasible speed of that pass has within a turn. Nothing changes on error.
/// @param table  NULL: none
/// @param pass   that start cuts next
/// @return       cam_ok, cam_err_busy (also while a wave plays), or an error of cam_build_config(),
///               whose refusal is kept
CAM_MUST_USE cam_err_t cam_machine_hand_over(cam_machine_t *m, const cam_params_t *params,
                                             const cam_table_t *table, uint32_t pass);

#endif
