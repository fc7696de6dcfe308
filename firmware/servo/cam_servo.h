// SPDX-License-Identifier: Apache-2.0
/// cam_servo: the position loop of a force drive (voice coil, linear motor on a current amplifier).
///
///     set-point --+--> feed-forward -----------------------+
///                 v                                        v
///     scale --> error --> PI with lead --> notch --------> + --> limits --> force
///                            ^                                     |
///                            +---- integral held while limited <---+
///
/// Forces are in mN / 64 (`_q6`): with errors in nm / 64 a gain of 1 N/um then is the number 1, and
/// a word holds 33 kN. The quantum of 16 uN is below a thousandth of the step of a 16-bit output of
/// 1 kN.
///
/// - PI with lead: the bilinear transform of K (1 + wi/s) (1 + s/wz) / (1 + s/wp), as a sum of P,
///   I and a filtered D. The integral is exact: its 64 bits hold every rounding error.
/// - Notch: a biquad on the force; its gain at 0 Hz is exactly 1, its rounding error is carried on.
/// - A constant error gives one force or two adjacent ones, plus the ramp of the integral.
/// - Feed-forward: mass x acceleration + drag x speed + friction by the sense of motion +
///   stiffness x position, of the set-point that was given. It is led by the whole delay when that
///   set-point is due when the force acts. A force from outside, the push, is added to it.
/// - Limits: force, change of force per step, and heat: a first-order model of the force squared.
///   A hot drive is limited to its continuous force until the model has cooled to 7/8.
/// - The integral is held while a limit cuts the force in the direction of the error.
///
/// Errors, in quanta: P with I, feed-forward and notch 1 each, D at most 1 / (1 - pole), 33 for
/// 100 Hz at 20 kHz. Error: 1/32 nm, and 3 nm of 0.5 mm at 100 Hz that are led by 150 us. Any
/// inputs are allowed: sums saturate, and jerks beyond 2^27 wrap.
/// A loop at two or three times the rate of the tick takes a set-point of its own in each step.
/// Coefficients: cam_servo_design(). Source: MATHS.md (233) .. (237).
/// Context: ISR, constant time, cannot fail; no division, no floating point, no state of its own.
#ifndef CAM_SERVO_H
#define CAM_SERVO_H

#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, int64_t

enum {
    cam_servo_most_q6 = (1 << 28) - 1,  ///< [mN / 64] largest force, 4.2 kN
    cam_servo_most_gain = 1 << 30,      ///< largest coefficient that multiplies an input
    cam_servo_hot_q22 = 1 << 22,        ///< heat of the continuous force
    cam_servo_cold_q22 = 7 * (1 << 19), ///< heat at which a hot drive gets its full force again
    cam_servo_most_overload = 15,       ///< largest force limit, times the continuous force
};

/// Biquad with the gain 1 at 0 Hz: b0 + b1 + b2 = 1 + a1 + a2 exactly, a1 = b1.
typedef struct {
    int32_t b0_q30;       ///< 0 .. 1
    int32_t b1_q30;       ///< -2 .. 0
    int32_t b2_q30;       ///< -1 .. 1
    int32_t minus_a2_q30; ///< -1 .. 1
} cam_servo_notch_t;

/// Time from the instant of a set-point to that of the reading, negative where the set-point is
/// led.
typedef struct {
    int32_t steps_q16;       ///< [steps] h, -16 .. 0
    int32_t half_square_q16; ///< h^2 / 2
    int32_t third_q28;       ///< h / 3
} cam_servo_ahead_t;

/// Coefficients, made by cam_servo_design(). Gains are 0 .. cam_servo_most_gain.
typedef struct {
    int32_t kp_q18;   ///< [N/um]
    int32_t kd_q18;   ///< [N/um] of the change of the error per step
    int32_t pole_q18; ///< of D, 0 .. 1
    int32_t ki_q32;   ///< [N/um per step]
    cam_servo_notch_t notch;
    int32_t mass_q14;       ///< [mN per nm/step^2]
    int32_t drag_q14;       ///< [mN per nm/step]
    int32_t stiffness_q18;  ///< [N/um]
    int32_t friction_q12;   ///< [mN]
    int32_t limit_q6;       ///< [mN / 64] 0 .. cam_servo_most_q6
    int32_t rate_q6;        ///< [mN / 64 per step] 0 .. 2^29
    int32_t continuous_q6;  ///< [mN / 64] at least limit_q6 / cam_servo_most_overload
    int32_t per_continuous; ///< 2^43 / continuous_q6
    int32_t cooling_q32;    ///< step over the thermal time constant, 0 .. 1/2
    cam_servo_ahead_t ahead;
} cam_servo_config_t;

/// What a step needs to know. Speed and acceleration are per step of this loop.
typedef struct {
    int32_t set_q6;    ///< [nm / 64] set-point
    int32_t vel_q10;   ///< [nm / 1024 per step] its speed
    int32_t acc_q10;   ///< [nm / 1024 per step^2] its acceleration
    int32_t actual_q6; ///< [nm / 64] reading of the scale
    int32_t push_q6;   ///< [mN / 64] force that is added
} cam_servo_input_t;

/// State; zero-initialised the drive is cold, and cam_servo_start_isr() must come first.
typedef struct {
    int64_t sum_q38;    ///< [mN / 2^38] integral
    int32_t error_q6;   ///< [nm / 64] of the last step
    int32_t acc_q10;    ///< [nm / 1024 per step^2] of the last step
    int32_t lead_q6;    ///< [mN / 64] D of the last step
    int32_t most_q6;    ///< [mN / 64] additional limit, set by the caller; 0: none
    int64_t first_q36;  ///< [mN / 2^36] state of the notch: for the next output,
    int64_t second_q36; ///< [mN / 2^36] and for the one after it
    int32_t force_q6;   ///< [mN / 64] of the last step
    int64_t heat_q54;   ///< of the thermal model; the continuous force tends to 1
    bool is_limited;    ///< a limit cut the force of the last step
    bool is_hot;        ///< the force is limited to the continuous one
} cam_servo_t;

/// Begin to control: no force, no integral, no kick of D. The heat stays.
/// @param in  of this step, which may follow at once
void cam_servo_start_isr(cam_servo_t *s, const cam_servo_config_t *cfg,
                         const cam_servo_input_t *in);

/// Calculate the force of a step.
/// @return [mN / 64] within limit_q6 and within rate_q6 of the last step; where the limit falls
///         (hot drive) the rate takes precedence
int32_t cam_servo_step_isr(cam_servo_t *s, const cam_servo_config_t *cfg,
                           const cam_servo_input_t *in);

/// A step without control: a given force, at once, within the limits of force and heat.
/// @return [mN / 64]
int32_t cam_servo_push_isr(cam_servo_t *s, const cam_servo_config_t *cfg, int32_t wanted_q6);

/// A step without control: the force is 0, the drive cools.
void cam_servo_rest_isr(cam_servo_t *s, const cam_servo_config_t *cfg);

#endif
