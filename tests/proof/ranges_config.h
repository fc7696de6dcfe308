// SPDX-License-Identifier: Apache-2.0
/// ranges_config: between which numbers every member of a configuration lies that cam_build.h
/// makes. X(member, lowest, highest). The proof takes any of them, each by itself;
/// test_cam_ranges.c holds them against configurations of any parameters.
#ifndef PROOF_RANGES_CONFIG_H
#define PROOF_RANGES_CONFIG_H

#include <stdint.h> // INT64_C

#define Q30 (INT64_C(1) << 30)       ///< 1 in q30
#define TURN (INT64_C(1) << 32)      ///< a turn in q32
#define POSITION (INT64_C(1) << 60)  ///< [turn / 2^32] 2^28 turns: two months at 3000 r/min
#define PART_MOST (INT64_C(1) << 54) ///< [turn / 2^32] 2^22 turns of a part
enum { WAVE_SAMPLES = 4096 };        ///< of a wave that U plays

#define SPINDLE_CONFIG(X)                                                                          \
    X(sign_mask, 0, UINT32_MAX)                                                                    \
    X(counts_per_turn, 64, 1 << 24)                                                                \
    X(turn_per_count_q32, 256, 1 << 26)                                                            \
    X(turn_per_count_fraction, 0, UINT32_MAX)                                                      \
    X(centre_q32, 0, UINT32_MAX)                                                                   \
    X(kp_q31, 0, INT32_MAX)                                                                        \
    X(ki_q32, 0, Q30 + Q30 / 16)                                                                   \
    X(index_tolerance, 0, 1000000)                                                                 \
    X(index_overdue, 72, (1 << 24) + (1 << 21))                                                    \
    X(jump_window, 0, 1 << 22)                                                                     \
    X(max_counts, 16, 1 << 22)                                                                     \
    X(still_counts, 3, 1 << 22)                                                                    \
    X(still_q32, 1024, INT32_MAX)                                                                  \
    X(inertia_q32, 0, cam_most_inertia_q32)                                                        \
    X(inertia_window_q32, 0, 1 << 29)                                                              \
    X(tick_clocks, 0, UINT32_MAX)                                                                  \
    X(early_clocks, 0, UINT32_MAX)                                                                 \
    X(on_time_clocks, 0, UINT32_MAX)                                                               \
    X(late_clocks, 0, UINT32_MAX)                                                                  \
    X(most_clocks, 0, UINT32_MAX)                                                                  \
    X(ticks_per_clock_q27, 0, UINT32_MAX)                                                          \
    X(stamp_clocks, 0, UINT32_MAX)

#define SCALE_CONFIG(X)                                                                            \
    X(speed_shift, 0, 20)                                                                          \
    X(offset, -(INT64_C(1) << 31) + 256, (INT64_C(1) << 31) - 256)                                 \
    X(scale_down, 0, 4)                                                                            \
    X(y_up, 0, 4)                                                                                  \
    X(v_up, 0, 31)                                                                                 \
    X(a_down, 0, 31)                                                                               \
    X(a_shift, 1, 31)                                                                              \
    X(alpha_shift, 1, 62)

#define SWING_CONFIG(X)                                                                            \
    X(is_swung, 0, 1)                                                                              \
    X(ahead_q16, 0, INT32_MAX)                                                                     \
    X(lag_q16, 0, INT32_MAX)                                                                       \
    X(ahead2, 0, 1 << 21)                                                                          \
    X(following_q32, 0, Q30)                                                                       \
    X(offset_q30, -(1 << 28), 1 << 28)                                                             \
    X(unit_q30, 0, INT32_MAX)                                                                      \
    X(gentle.speed_q32, 0, 1 << 24)                                                                \
    X(gentle.step_q32, 0, Q30)                                                                     \
    X(gentle.gain_q32, 0, Q30)                                                                     \
    X(full.speed_q32, 0, 1 << 24)                                                                  \
    X(full.step_q32, 0, Q30)                                                                       \
    X(full.gain_q32, 0, Q30)

#define LIMITS(X)                                                                                  \
    X(speed_q10, 1, 1 << 29)                                                                       \
    X(acceleration_q10, 1, 1 << 29)                                                                \
    X(log2_window, 0, 6)

#define PLAY_CONFIG(X)                                                                             \
    X(lead_q16, 0, 62 * 65536)                                                                     \
    X(plan_ticks, 1, 40)                                                                           \
    X(per_plan_q30, Q30 / 40, Q30)                                                                 \
    X(xz_lag_q16, 0, 10000 * 65536)                                                                \
    X(u_plan_q16, 65536, 102 * 65536)                                                              \
    X(xz_plan_q16, 65536, 10040 * 65536)                                                           \
    X(commanded_q16, 0, 10000 * 65536)                                                             \
    X(ratio_q16, 2 * 65536, 41 * 65536)                                                            \
    X(xz_lag2, 0, 1 << 21)                                                                         \
    X(height_max_q32, 0, 4095 * TURN - 64)                                                         \
    X(phase_q32, INT32_MIN, INT32_MAX)                                                             \
    X(phase_step_q32, 1, 1 << 22)                                                                  \
    X(amplitude_q30, 0, Q30 + Q30 / 4)                                                             \
    X(amplitude_step_q30, 1, 1 << 25)                                                              \
    X(engage_q32, TURN, 100 * TURN)                                                                \
    X(disengage_q32, TURN, 100 * TURN)                                                             \
    X(per_engage_q31, (1u << 31) / 100, 1u << 31)                                                  \
    X(per_disengage_q31, (1u << 31) / 100, 1u << 31)                                               \
    X(rehearse_q32, 0, 1000 * TURN)                                                                \
    X(rehearse_x_q10, 0, INT64_C(1) << 34)                                                         \
    X(feed_q32, 0, INT64_MAX)                                                                      \
    X(ramp_q32, TURN / 2, 100 * TURN)                                                              \
    X(per_ramp_q31, (1u << 31) / 100 - 1, UINT32_MAX)                                              \
    X(stop_ramp_q32, TURN / 2, 100 * TURN)                                                         \
    X(per_stop_q31, (1u << 31) / 100 - 1, UINT32_MAX)                                              \
    X(rings.is_on, 0, 1)                                                                           \
    X(feed_nm, 1, 10000000)                                                                        \
    X(z_first_nm, -1000000000, 1000000000)                                                         \
    X(z_origin_nm, INT32_MIN, INT32_MAX)                                                           \
    X(z_low_nm, INT32_MIN, INT32_MAX)                                                              \
    X(z_high_nm, INT32_MIN, INT32_MAX)                                                             \
    X(z_margin_nm, 0, 10000000)                                                                    \
    X(turning_q32, 0, INT32_MAX)                                                                   \
    X(dwell_ticks, 1, 500001)                                                                      \
    X(is_z_measured, 0, 1)                                                                         \
    X(u_retract_q10, -(INT64_C(1) << 35), INT64_C(1) << 35)                                        \
    X(x_clearance_nm, 0, 200000000)                                                                \
    X(x_high_nm, INT32_MIN, INT32_MAX)                                                             \
    X(x_clear_q10, -(INT64_C(1) << 43), INT64_C(1) << 43)                                          \
    X(x_offset_q10, -(INT64_C(1) << 43), INT64_C(1) << 43)                                         \
    X(spindle_mrpm, -60000000, 60000000)                                                           \
    X(feed_rate_q30, 0, Q30 + Q30 / 2)                                                             \
    X(per_feed_rate_q24, 0, 100 << 24)                                                             \
    X(x_trim_q4, -(1 << 25), 1 << 25)                                                              \
    X(x_trim_step_q4, 1, 1 << 25)                                                                  \
    X(spindle_rate_q30, Q30 / 2, Q30 + Q30 / 5 + 1)                                                \
    X(spindle_step_q30, 1, 1 << 25)

#define RINGS_CONFIG(X)                                                                            \
    X(ramp_q32, 0, 1u << 31)                                                                       \
    X(per_ramp_q24, 0, UINT32_MAX)                                                                 \
    X(per_rest_q30, 0, 2 * Q30)                                                                    \
    X(feed_nm, 0, 10000000)                                                                        \
    X(span_nm, 0, 2000000000)

#define SPEED_CONFIG(X)                                                                            \
    X(mean_mrpm, 0, 60000000)                                                                      \
    X(limit_mrpm, 0, 60000000)                                                                     \
    X(sense, -1, 1)                                                                                \
    X(lag_q16, 0, INT32_MAX)                                                                       \
    X(mean_q32, 0, 1 << 26)

#define EXCITE_CONFIG(X)                                                                           \
    X(n, 0, WAVE_SAMPLES)                                                                          \
    X(first, 0, WAVE_SAMPLES - 1)                                                                  \
    X(n_play, 0, UINT32_MAX)                                                                       \
    X(fade.speed_q10, 0, Q30)                                                                      \
    X(fade.acceleration_q10, 0, Q30)                                                               \
    X(place_q10, -(INT64_C(1) << 35), INT64_C(1) << 35)                                            \
    X(is_force, 0, 1)

#define ORDER(X)                                                                                   \
    X(serial, 0, UINT32_MAX)                                                                       \
    X(until, 0, UINT32_MAX)                                                                        \
    X(begin, 0, 4)                                                                                 \
    X(axis, 0, 2)                                                                                  \
    X(sense, -1, 1)                                                                                \
    X(has_index, 0, 1)                                                                             \
    X(speed_q10, 0, 1 << 29)                                                                       \
    X(slow_q10, 0, 1 << 29)                                                                        \
    X(low_q10, -(INT64_C(1) << 45), INT64_C(1) << 45)                                              \
    X(high_q10, -(INT64_C(1) << 45), INT64_C(1) << 45)                                             \
    X(distance_q10, -(INT64_C(1) << 45), INT64_C(1) << 45)                                         \
    X(home_nm, -15000000, 15000000)                                                                \
    X(press_q6, 0, 64 * 200000)

#define GUARD_CONFIG(X)                                                                            \
    X(overspeed_q32, 0, INT32_MAX)                                                                 \
    X(stopped_ticks, 0, 1000000)                                                                   \
    X(homing_ticks, 0, 100000000)                                                                  \
    X(following_nm, 0, INT32_MAX)                                                                  \
    X(approach_nm, 0, INT32_MAX)                                                                   \
    X(due_ticks, 0, 62)                                                                            \
    X(due_part_q31, 0, INT32_MAX)                                                                  \
    X(range_nm, 0, 15000000)                                                                       \
    X(u_vel_q6, 1, 1 << 26)                                                                        \
    X(u_acc_q6, 1, 1 << 26)                                                                        \
    X(u_acc_off_q6, 1, 1 << 27)                                                                    \
    X(step_nm, 0, INT32_MAX / 2)                                                                   \
    X(change_nm, 0, INT32_MAX / 2)                                                                 \
    X(change_off_nm, 0, INT32_MAX / 2)                                                             \
    X(u_retract_q10, -(INT64_C(1) << 35), INT64_C(1) << 35)

#define COMMAND_CONFIG(X)                                                                          \
    X(configured.k1_q16, 0, Q30)                                                                   \
    X(configured.k2_q16, -INT32_MAX, INT32_MAX)                                                    \
    X(configured.friction_q14, 0, 16384 * 100000)                                                  \
    X(in_cut.k1_q16, -Q30, Q30)                                                                    \
    X(in_cut.k2_q16, -INT32_MAX, INT32_MAX)                                                        \
    X(in_cut.friction_q14, -16384 * 30000, 16384 * 130000)                                         \
    X(in_cut.chip_q32, -(1 << 29), 1 << 29)                                                        \
    X(in_cut.chip_q6, -64 * 30000, 64 * 30000)

#define COMMAND_AXIS_CONFIG(X)                                                                     \
    X(vel_q10[i], 0, INT32_MAX)                                                                    \
    X(change_q10[i], 0, INT32_MAX)                                                                 \
    X(jump_q10[i], 0, INT32_MAX)

#define FORCE_CONFIG(X)                                                                            \
    X(is_used, 0, 1)                                                                               \
    X(servo.kp_q18, 0, Q30)                                                                        \
    X(servo.kd_q18, 0, Q30)                                                                        \
    X(servo.pole_q18, 0, 1 << 18)                                                                  \
    X(servo.ki_q32, 0, Q30)                                                                        \
    X(servo.notch.b0_q30, 0, Q30)                                                                  \
    X(servo.notch.b1_q30, -2 * Q30, 0)                                                             \
    X(servo.notch.b2_q30, -Q30, Q30)                                                               \
    X(servo.notch.minus_a2_q30, -Q30, Q30)                                                         \
    X(servo.mass_q14, 0, Q30)                                                                      \
    X(servo.drag_q14, 0, Q30)                                                                      \
    X(servo.stiffness_q18, 0, Q30)                                                                 \
    X(servo.friction_q12, 0, 200000 * 4096)                                                        \
    X(servo.limit_q6, 0, cam_servo_most_q6)                                                        \
    X(servo.rate_q6, 0, 1 << 29)                                                                   \
    X(servo.continuous_q6, 0, cam_servo_most_q6)                                                   \
    X(servo.per_continuous, 0, INT32_MAX)                                                          \
    X(servo.cooling_q32, 0, 1 << 27)                                                               \
    X(servo.ahead.steps_q16, -16 * 65536, 0)                                                       \
    X(servo.ahead.half_square_q16, 0, 1 << 23)                                                     \
    X(servo.ahead.third_q28, -Q30 - Q30 / 2, 0)                                                    \
    X(motion_q24, 0, INT32_MAX)                                                                    \
    X(pos_q18, 0, 1 << 18)                                                                         \
    X(vel_q24, 0, 1 << 22)                                                                         \
    X(held_q10, 0, INT32_MAX)                                                                      \
    X(push_speed_q10, 0, 1 << 29)                                                                  \
    X(quantum_q10, 0, 10000 * 1024)                                                                \
    X(unseen_nm, 0, 40100)                                                                         \
    X(runaway_q6, 0, INT32_MAX)                                                                    \
    X(travel_nm, 0, Q30 - 1)                                                                       \
    X(braking_nm, 0, INT32_MAX)

#define ACKNOWLEDGE_CONFIG(X)                                                                      \
    X(is_demanded, 0, 1)                                                                           \
    X(settle_plans, 0, UINT32_MAX)                                                                 \
    X(least_plans, 0, UINT32_MAX)                                                                  \
    X(most_plans, 0, UINT32_MAX)                                                                   \
    X(good_plans, 0, UINT32_MAX)

#define CHANNEL(X)                                                                                 \
    X(n_slices, 2, 4096)                                                                           \
    X(frac_bits, 0, 8)                                                                             \
    X(z_first_nm, -1000000000, 1000000000)                                                         \
    X(span_nm, 1, 2000000000)                                                                      \
    X(slices_per_nm_q48, 0, UINT32_MAX)

#define LOBE(X)                                                                                    \
    X(z_first_nm, -1000000000, 1000000000)                                                         \
    X(z_last_nm, -1000000000, 1000000000)                                                          \
    X(phase_q32, 0, UINT32_MAX)                                                                    \
    X(pattern, 0, 4095)                                                                            \
    X(changes_per_nm_q48, 0, UINT32_MAX)

#define WHOLE_CONFIG(X) X(play.jog.u_end_q10, 0, INT64_C(1) << 34)

#endif
