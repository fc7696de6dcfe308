// SPDX-License-Identifier: Apache-2.0
/// ranges_state: between which numbers the members of the controller lie when a tick begins, and
/// again when it has ended. X(member, lowest, highest). The proof takes any of them, each by
/// itself; a member that is not named here may be any number of its type.
#ifndef PROOF_RANGES_STATE_H
#define PROOF_RANGES_STATE_H

#include "ranges_config.h" // TURN, POSITION

#define SPINDLE(X)                                                                                 \
    X(is_started, 0, 1)                                                                            \
    X(is_synced, 0, 1)                                                                             \
    X(is_off_time, 0, 1)                                                                           \
    X(is_plan_off_time, 0, 1)                                                                      \
    X(n_left_out, 0, 15)                                                                           \
    X(behind, -(1 << 22), 0)

#define JERK_FILTER(X)                                                                             \
    X(slope_q10, -Q30, Q30)                                                                        \
    X(n_line, 0, 64)                                                                               \
    X(n_still, 0, 64)                                                                              \
    X(log2_window, 0, 6)

#define ACKNOWLEDGE(X)                                                                             \
    X(phase, 0, cam_acknowledge_used)                                                              \
    X(is_pressed, 0, 1)

#define MOTION(X)                                                                                  \
    X(state, 0, cam_n_states - 1)                                                                  \
    X(is_playing, 0, 1)                                                                            \
    X(is_stopping, 0, 1)                                                                           \
    X(was_off, 0, 1)                                                                               \
    X(is_clear, 0, 1)                                                                              \
    X(is_retracted, 0, 1)                                                                          \
    X(is_by_hand, 0, 1)                                                                            \
    X(is_u_beyond, 0, 1)                                                                           \
    X(was_open, 0, 1)                                                                              \
    X(is_acknowledged, 0, 1)                                                                       \
    X(u.nm, -(1 << 25), (1 << 25) - 1)                                                             \
    X(u_speed_q10, 0, 1 << 29)                                                                     \
    X(is_filtering, 0, 1)                                                                          \
    X(u_press_q6, 0, 64 * 200000)                                                                  \
    X(x_left_q10, -(INT64_C(1) << 41), INT64_C(1) << 41)                                           \
    X(phase_step_q32, -(1 << 22), 1 << 22)                                                         \
    X(swing.is_new, 0, 1)                                                                          \
    X(swing.is_there, 0, 1)

#define FORCE(X)                                                                                   \
    X(is_on, 0, 1)                                                                                 \
    X(servo.sum_q38, -(Q30 << 30), (Q30 << 30) - 1)                                                \
    X(servo.lead_q6, -(1 << 28), (1 << 28) - 1)                                                    \
    X(servo.most_q6, 0, 64 * 200000)                                                               \
    X(servo.first_q36, -(Q30 << 32), Q30 << 32)                                                    \
    X(servo.second_q36, -5 * (Q30 << 28), 5 * (Q30 << 28))                                         \
    X(servo.force_q6, -cam_servo_most_q6, cam_servo_most_q6)                                       \
    X(servo.heat_q54, -(Q30 << 28), (Q30 << 32) + (Q30 << 28))                                     \
    X(servo.is_limited, 0, 1)                                                                      \
    X(servo.is_hot, 0, 1)

#define PLAY(X) X(excite.at, 0, WAVE_SAMPLES - 1)

#define JOG(X)                                                                                     \
    X(phase, 0, cam_jog_n_phases - 1)                                                              \
    X(end, 0, cam_jog_n_ends - 1)                                                                  \
    X(axis, 0, hal_n_axes - 1)

#define PLAN(X)                                                                                    \
    X(measured_nm, -Q30, Q30 - 1)                                                                  \
    X(amplitude_q30, 0, Q30 + Q30 / 4)                                                             \
    X(ratio_q28, -(10 << 24), 117 << 24)                                                           \
    X(x_trim_q4, -(1 << 25), 1 << 25)                                                              \
    X(spindle_rate_q30, 0, Q30 + Q30 / 5 + 1)                                                      \
    X(is_rehearsal, 0, 1)                                                                          \
    X(is_stopped, 0, 1)                                                                            \
    X(shaft.i_lobe, 0, 63)

#define SENSED(X)                                                                                  \
    X(in.actual_nm[0], -Q30, Q30 - 1)                                                              \
    X(in.actual_nm[1], -Q30, Q30 - 1)                                                              \
    X(in.actual_nm[2], -Q30, Q30 - 1)                                                              \
    X(force_q6, -cam_servo_most_q6, cam_servo_most_q6)

#define FEED_MOTION(X)                                                                             \
    X(rate_q30, 0, Q30 + Q30 / 2)                                                                  \
    X(to_rate_q30, 0, Q30 + Q30 / 2)                                                               \
    X(per_brake_q31, 0, UINT32_MAX)                                                                \
    X(requested_q30, 0, Q30 + Q30 / 2)                                                             \
    X(is_held, 0, 1)

#define WHOLE_STATE(X)                                                                             \
    X(bins.is_clean, 0, 1)                                                                         \
    X(bins.now.state, 0, cam_n_states - 1)                                                         \
    X(bins.now.is_steady, 0, 1)                                                                    \
    X(bins.now.is_level, 0, 1)

#endif
