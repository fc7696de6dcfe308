// SPDX-License-Identifier: Apache-2.0
/// ranges_state: between which numbers the members of the controller lie when a tick begins.
/// X(member, lowest, highest). The proof takes any of them, each by itself.
#ifndef PROOF_RANGES_STATE_H
#define PROOF_RANGES_STATE_H

#include "ranges_config.h" // TURN, POSITION

#define SPINDLE(X)                                                                                 \
    X(is_started, 0, 1)                                                                            \
    X(is_synced, 0, 1)                                                                             \
    X(clock, 0, UINT32_MAX)                                                                        \
    X(counts, 0, UINT32_MAX)                                                                       \
    X(n_index, 0, UINT32_MAX)                                                                      \
    X(index_counts, 0, UINT32_MAX)                                                                 \
    X(index_error, INT32_MIN, INT32_MAX)                                                           \
    X(in_turn, 0, (1 << 24) - 1)                                                                   \
    X(is_off_time, 0, 1)                                                                           \
    X(max_period, 0, UINT32_MAX)                                                                   \
    X(n_late, 0, UINT32_MAX)                                                                       \
    X(pos_q32, -POSITION, POSITION)                                                                \
    X(speed_q64, INT64_MIN, INT64_MAX)

#define AXIS(X)                                                                                    \
    X(pos_q10, -(INT64_C(1) << 50), INT64_C(1) << 50)                                              \
    X(vel_q10, -(Q30), Q30)                                                                        \
    X(acc_q10, INT32_MIN, INT32_MAX)

#define GLIDE(X)                                                                                   \
    X(sum_pos_q10, -(INT64_C(1) << 56), INT64_C(1) << 56)                                          \
    X(sum_vel_q10, -(INT64_C(1) << 40), INT64_C(1) << 40)                                          \
    X(line_q10, INT32_MIN, INT32_MAX)                                                              \
    X(slope_q10, -Q30, Q30)                                                                        \
    X(n_line, 0, 64)                                                                               \
    X(n_still, 0, 64)                                                                              \
    X(log2_window, 0, 6)                                                                           \
    X(at, 0, UINT32_MAX)

#define ACKNOWLEDGE(X)                                                                             \
    X(phase, 0, 3)                                                                                 \
    X(is_pressed, 0, 1)                                                                            \
    X(n_other, 0, UINT32_MAX)                                                                      \
    X(n_plans, 0, UINT32_MAX)

#define MOTION(X)                                                                                  \
    X(state, 0, 10)                                                                                \
    X(spindle_mrpm, INT32_MIN, INT32_MAX)                                                          \
    X(is_playing, 0, 1)                                                                            \
    X(is_stopping, 0, 1)                                                                           \
    X(was_off, 0, 1)                                                                               \
    X(is_clear, 0, 1)                                                                              \
    X(is_retracted, 0, 1)                                                                          \
    X(is_by_hand, 0, 1)                                                                            \
    X(was_open, 0, 1)                                                                              \
    X(is_acknowledged, 0, 1)                                                                       \
    X(u_speed_q10, 0, 1 << 29)                                                                     \
    X(is_gliding, 0, 1)                                                                            \
    X(u_home_nm, INT32_MIN / 2, INT32_MAX / 2)                                                     \
    X(faults, 0, UINT32_MAX)                                                                       \
    X(c_q6, INT32_MIN, INT32_MAX)                                                                  \
    X(u_target_q10, -(INT64_C(1) << 35), INT64_C(1) << 35)                                         \
    X(x_left_q10, -(INT64_C(1) << 50), INT64_C(1) << 50)                                           \
    X(height_q32, 0, 4095 * TURN - 64)                                                             \
    X(height_step_q32, -(INT64_C(1) << 31), (INT64_C(1) << 31) - 1)                                \
    X(scale_q30, -(Q30 + Q30 / 2), Q30 + Q30 / 2)                                                  \
    X(scale_step_q30, -(Q30 / 4), Q30 / 4)                                                         \
    X(behind_q4, -(INT64_C(1) << 30), INT64_C(1) << 30)                                            \
    X(behind_step_q4, -(INT64_C(1) << 28), INT64_C(1) << 28)                                       \
    X(phase_q32, INT32_MIN, INT32_MAX)                                                             \
    X(phase_step_q32, -(1 << 22), 1 << 22)                                                         \
    X(alpha_q40, INT32_MIN, INT32_MAX)                                                             \
    X(alpha_u, INT32_MIN, INT32_MAX)                                                               \
    X(swing.set.pos_q32, INT32_MIN, INT32_MAX)                                                     \
    X(swing.set.vel_q32, INT32_MIN, INT32_MAX)                                                     \
    X(swing.is_new, 0, 1)                                                                          \
    X(swing.is_there, 0, 1)

#define PLAY(X)                                                                                    \
    X(request, 0, UINT32_MAX)                                                                      \
    X(n_history, 0, UINT32_MAX)                                                                    \
    X(due_q6, INT32_MIN, INT32_MAX)                                                                \
    X(excite.at, 0, WAVE_SAMPLES - 1)                                                              \
    X(excite.n_left, 0, UINT32_MAX)                                                                \
    X(excite.gain.pos_q10, -(Q30), 2 * Q30)                                                        \
    X(excite.gain.vel_q10, -(Q30), Q30)                                                            \
    X(excite.gain.acc_q10, INT32_MIN, INT32_MAX)

#define GUARD(X)                                                                                   \
    X(faults, 0, UINT32_MAX)                                                                       \
    X(counted, 0, UINT32_MAX)                                                                      \
    X(first_faults, 0, UINT32_MAX)                                                                 \
    X(is_retracted, 0, 1)                                                                          \
    X(n_stopped, 0, UINT32_MAX)                                                                    \
    X(u_set_q6, INT32_MIN, INT32_MAX)                                                              \
    X(u_step_q6, INT32_MIN, INT32_MAX)

#define TELL(X)                                                                                    \
    X(u.nm, INT32_MIN, INT32_MAX)                                                                  \
    X(u.step_nm, INT32_MIN, INT32_MAX)                                                             \
    X(fading_q6, INT32_MIN, INT32_MAX)

#define SWITCHES(X)                                                                                \
    X(on, 0, UINT32_MAX)                                                                           \
    X(open, 0, UINT32_MAX)                                                                         \
    X(held, 0, UINT32_MAX)                                                                         \
    X(next, 0, cam_n_switches - 1)

#define HAND(X)                                                                                    \
    X(serial, 0, UINT32_MAX)                                                                       \
    X(phase, 0, 6)                                                                                 \
    X(end, 0, 9)                                                                                   \
    X(axis, 0, 2)                                                                                  \
    X(target_q10, -(INT64_C(1) << 50), INT64_C(1) << 50)                                           \
    X(homed, 0, UINT32_MAX)                                                                        \
    X(n_found, 0, UINT32_MAX)

#define PLAN(X)                                                                                    \
    X(engage_at_q32, -POSITION, POSITION)                                                          \
    X(feed_at_q32, -POSITION, POSITION)                                                            \
    X(disengage_at_q32, -POSITION, INT64_MAX / 2)                                                  \
    X(measured_nm, INT32_MIN, INT32_MAX)                                                           \
    X(amplitude_q30, 0, Q30 + Q30 / 4)                                                             \
    X(ratio_q28, 1 << 24, Q30)                                                                     \
    X(x_trim_q4, -(1 << 25), 1 << 25)                                                              \
    X(spindle_rate_q30, Q30 / 2, Q30 + Q30 / 5 + 1)                                                \
    X(is_rehearsal, 0, 1)                                                                          \
    X(is_stopped, 0, 1)                                                                            \
    X(course.from_q32, -POSITION, POSITION)                                                        \
    X(course.to_q32, -POSITION, POSITION)                                                          \
    X(course.fed_q32, -POSITION, POSITION)                                                         \
    X(course.fed_to_q32, -POSITION, POSITION)                                                      \
    X(course.brake_q32, -POSITION, POSITION)                                                       \
    X(course.end_q32, -POSITION, POSITION)                                                         \
    X(course.fed_end_q32, -POSITION, POSITION)                                                     \
    X(course.rate_q30, 0, Q30 + Q30 / 2)                                                           \
    X(course.to_rate_q30, 0, Q30 + Q30 / 2)                                                        \
    X(course.asked_q30, 0, Q30 + Q30 / 2)                                                          \
    X(course.is_held, 0, 1)                                                                        \
    X(shaft.i_lobe, 0, 63)                                                                         \
    X(shaft.phase_q32, 0, UINT32_MAX)                                                              \
    X(shaft.z_q8, -(INT64_C(1) << 50), INT64_C(1) << 50)                                           \
    X(shaft.speed_q8, -(INT64_C(1) << 50), INT64_C(1) << 50)

#define RECORD(X)                                                                                  \
    X(tick, 0, UINT32_MAX)                                                                         \
    X(config, 0, UINT32_MAX)                                                                       \
    X(in.clock, 0, UINT32_MAX)                                                                     \
    X(in.encoder.counts, 0, UINT32_MAX)                                                            \
    X(in.encoder.index_counts, 0, UINT32_MAX)                                                      \
    X(in.encoder.n_index, 0, UINT32_MAX)                                                           \
    X(in.encoder.edge_clock, 0, UINT32_MAX)                                                        \
    X(in.actual_nm[0], INT32_MIN, INT32_MAX)                                                       \
    X(in.actual_nm[1], INT32_MIN, INT32_MAX)                                                       \
    X(in.actual_nm[2], INT32_MIN, INT32_MAX)                                                       \
    X(in.swing_q32, INT32_MIN, INT32_MAX)                                                          \
    X(in.inputs, 0, UINT32_MAX)                                                                    \
    X(in.request, 0, UINT32_MAX)                                                                   \
    X(angle.pos_q32, -POSITION, POSITION)                                                          \
    X(angle.measured_q32, 0, UINT32_MAX)                                                           \
    X(angle.speed_q32, INT32_MIN, INT32_MAX)                                                       \
    X(angle.is_off_time, 0, 1)                                                                     \
    X(angle.is_synced, 0, 1)                                                                       \
    X(angle.faults, 0, UINT32_MAX)                                                                 \
    X(want.state, 0, 10)                                                                           \
    X(want.spindle_mrpm, INT32_MIN, INT32_MAX)                                                     \
    X(want.z_nm, INT32_MIN, INT32_MAX)                                                             \
    X(want.u_set_q6, INT32_MIN, INT32_MAX)                                                         \
    X(want.u_due_q6, INT32_MIN, INT32_MAX)                                                         \
    X(want.faults, 0, UINT32_MAX)                                                                  \
    X(want.outputs, 0, UINT32_MAX)                                                                 \
    X(want.is_retracted, 0, 1)

#endif
