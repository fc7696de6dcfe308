// SPDX-License-Identifier: Apache-2.0
// The loop without its limits: frequency and step response, feed-forward, and what constants give.
#include "cam_servo.h"
#include "fixture_servo.h"
#include <complex.h> // cabs, carg
#include <math.h>    // cos, lround, pow, tan
#include <stdlib.h>  // labs

#define PI 3.14159265358979324

static cam_params_t p;
static cam_servo_t servo;

void setUp(void)
{
    p = bench_params;
    step_hz = 20000;
    p.servo_force_limit_mn = 4000000;
    p.servo_continuous_mn = 4000000;
    servo = (cam_servo_t){0};
}

/// PI with lead and notch at s; the notch has frequency w_notch.
static double complex response(double complex s, double complex s_notch, double w_notch)
{
    const double wc = 2.0 * PI * p.servo_crossover_hz;
    const double wp = 2.0 * PI * p.servo_pole_hz;
    const double wz = wp / (p.servo_lead_percent / 100.0);
    const double wi = 2.0 * PI * p.servo_integral_mHz / 1000.0;
    const double k =
        p.servo_mass_g / 1000.0 * wc * wc * cabs((1.0 + I * wc / wp) / (1.0 + I * wc / wz));
    const double zero = p.servo_notch_zero_permille / 1000.0;
    const double pole = p.servo_notch_pole_permille / 1000.0;
    const double complex q = s_notch / w_notch;
    const double complex notch = (q * q + 2.0 * zero * q + 1.0) / (q * q + 2.0 * pole * q + 1.0);
    return k * (1.0 + wi / s) * (1.0 + s / wz) / (1.0 + s / wp) *
           (p.servo_notch_hz > 0 ? notch : 1.0);
}

/// What the bilinear transform makes of it, the notch kept at its frequency.
static double complex discrete_response(double hz)
{
    const double complex s = I * 2.0 * step_hz * tan(PI * hz / step_hz);
    return response(s, s, 2.0 * step_hz * tan(PI * p.servo_notch_hz / step_hz));
}

/// [N/m] response of the loop to a sine of error. `periods` of it last a whole number of steps.
static double complex measured(double amplitude_nm, int periods, int steps)
{
    const cam_servo_config_t c = bench_config(&p);
    cam_servo_input_t in = {.set_q6 = 0};
    double complex force = 0.0;
    double complex error = 0.0;
    cam_servo_start_isr(&servo, &c, &in);
    for (int i = 0; i < 2 * steps; i++) {
        const double angle = 2.0 * PI * periods * i / steps;
        in.actual_q6 = -(int32_t)lround(64.0 * amplitude_nm * cos(angle));
        const int32_t force_q6 = cam_servo_step_isr(&servo, &c, &in);
        TEST_ASSERT_FALSE(servo.is_limited);
        if (i >= steps) {
            force += force_q6 * cexp(-I * angle);
            error -= in.actual_q6 * cexp(-I * angle);
        }
    }
    return force / error * 1e6;
}

static void expect_response(double complex right, double complex found, double within)
{
    TEST_ASSERT_DOUBLE_WITHIN(within, 0.0, cabs(found / right - 1.0));
}

static void test_response_is_the_bilinear_transform(void)
{
    static const int periods[] = {2, 7, 31, 117, 301, 469, 605, 1210, 2000, 4000, 7003, 9999};
    enum { steps = 20000 };
    for (int i = 0; i < 12; i++) {
        const double hz = periods[i] * (double)step_hz / steps;
        expect_response(discrete_response(hz), measured(3000.0, periods[i], steps), 1e-4);
    }
}

static void test_response_at_other_rates_masses_and_loops(void)
{
    p.servo_notch_hz = 0;
    expect_response(discrete_response(469.0), measured(3000.0, 469, 20000), 1e-4);
    step_hz = 60000;
    p.servo_pole_hz = 12000;
    p.servo_notch_hz = 300;
    expect_response(discrete_response(469.0), measured(3000.0, 469, 60000), 1e-4);
    p = bench_params;
    step_hz = 20000;
    p.servo_mass_g = 200; // to be commissioned
    p.servo_crossover_hz = 20;
    p.servo_lead_percent = 1000;
    p.servo_pole_hz = 100;
    p.servo_integral_mHz = 1000;
    expect_response(discrete_response(25.0), measured(20000.0, 25, 20000), 2e-3);
}

/// [mN / 64] force after n + 1 steps at an error of 64 nm, in closed form.
static double step_response(int n)
{
    const double x = PI * p.servo_pole_hz / step_hz;
    const double complex far = response(1e9, 1e9, 1.0); // its limits give the parts
    const double ki = creal(response(1e-9, 1.0, 1.0)) * 1e-9;
    const double wi = 2.0 * PI * p.servo_integral_mHz / 1000.0;
    const double tau = (p.servo_lead_percent / 100.0 - 1.0) / (2.0 * PI * p.servo_pole_hz);
    const double kp = ki / wi * (1.0 + wi * tau);
    const double kd = (creal(far) - kp) / (1.0 + x);
    const double pole = (1.0 - x) / (1.0 + x);
    const double sum = ki / step_hz * (n + 0.5);
    return (kp + kd * pow(pole, n) + sum) * 1e-6 * 64.0 * 64.0;
}

static void test_step_of_the_error(void)
{
    p.servo_notch_hz = 0;
    const cam_servo_config_t c = bench_config(&p);
    cam_servo_input_t in = {.set_q6 = 0};
    cam_servo_start_isr(&servo, &c, &in);
    in.set_q6 = 64 * 64;
    p.servo_stiffness_n_per_m = 0;
    for (int n = 0; n < 2000; n++) {
        const double right = step_response(n) + c.stiffness_q18 * 4096.0 / 262144.0;
        const double found = cam_servo_step_isr(&servo, &c, &in);
        TEST_ASSERT_DOUBLE_WITHIN(3.0 + 1e-5 * right, right, found);
    }
}

/// No limit cycle: without an integral a constant error ends in one force, or two that adjoin.
static void test_constant_error_gives_a_constant_force(void)
{
    p.servo_integral_mHz = 0;
    p.servo_stiffness_n_per_m = 0;
    const cam_servo_config_t c = bench_config(&p);
    for (int32_t error = -3000; error < 3000; error += 7) {
        cam_servo_input_t in = {.actual_q6 = 50000};
        cam_servo_start_isr(&servo, &c, &in);
        in.actual_q6 = error;
        for (int i = 0; i < 400; i++) {
            (void)cam_servo_step_isr(&servo, &c, &in);
        }
        const int32_t right = (int32_t)lround(-(double)c.kp_q18 * error / 262144.0);
        for (int i = 0; i < 50; i++) {
            TEST_ASSERT_INT32_WITHIN(1, right, cam_servo_step_isr(&servo, &c, &in));
        }
    }
}

/// The integral loses nothing: an error below every quantum of force adds up exactly.
static void test_integral_is_exact(void)
{
    p.servo_notch_hz = 0;
    p.servo_lead_percent = 100;
    const cam_servo_config_t c = bench_config(&p);
    const cam_servo_input_t in = {.actual_q6 = -1};
    cam_servo_start_isr(&servo, &c, &in);
    int32_t force = 0;
    for (int i = 0; i < 1000000; i++) {
        force = cam_servo_step_isr(&servo, &c, &in);
    }
    const double right = c.kp_q18 / 262144.0 + c.ki_q32 / 4294967296.0 * 1e6;
    TEST_ASSERT_DOUBLE_WITHIN(1.0, right, force);
}

/// At rest without error a motion gets what the mass, drag, friction and spring take.
static void test_feed_forward(void)
{
    p.u_scale_latency_ns = p.servo_force_delay_ns = 0;
    const cam_servo_config_t c = bench_config(&p);
    const double dt = 1.0 / step_hz;
    static const struct {
        double pos_m, vel, acc;
    } cases[] = {{0, 0, 197.0}, {0, 0.314, 0}, {0, -0.00004, 0}, {0.02, 0, 0}, {-0.01, -0.2, -150}};
    for (int i = 0; i < 5; i++) {
        const double vel_nm = cases[i].vel * dt * 1e9;
        const cam_servo_input_t in = {
            .set_q6 = (int32_t)lround(cases[i].pos_m * 64e9),
            .vel_q10 = (int32_t)lround(vel_nm * 1024.0),
            .acc_q10 = (int32_t)lround(cases[i].acc * dt * dt * 1024e9),
            .actual_q6 = (int32_t)lround(cases[i].pos_m * 64e9),
        };
        const double sense = vel_nm > 4.0 ? 1.0 : vel_nm < -4.0 ? -1.0 : vel_nm / 4.0;
        const double right_n =
            1.5 * cases[i].acc + 12.0 * cases[i].vel + 5.0 * sense + 900.0 * cases[i].pos_m;
        cam_servo_start_isr(&servo, &c, &in);
        const double found_n = cam_servo_step_isr(&servo, &c, &in) / 64e3;
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 + 1e-3 * fabs(right_n), right_n, found_n);
    }
}

/// A motion of 100 Hz that the scale follows without error gives none, however far it is led.
static void test_set_point_is_taken_to_the_instant_of_the_reading(void)
{
    static const struct {
        int32_t hz, delay_ns;
        double most_nm;
    } cases[] = {{20000, 0, 0.1}, {20000, 75000, 0.6}, {20000, 150000, 3.0}, {60000, 75000, 0.3}};
    for (int k = 0; k < 4; k++) {
        step_hz = cases[k].hz;
        p.u_scale_latency_ns = cases[k].delay_ns / 3;
        p.servo_force_delay_ns = cases[k].delay_ns - p.u_scale_latency_ns;
        const cam_servo_config_t c = bench_config(&p);
        const double w = 2.0 * PI * 100.0 / step_hz;
        for (int i = 0; i < 1200; i++) {
            const double at = i - cases[k].delay_ns * 1e-9 * step_hz;
            const cam_servo_input_t in = {
                .set_q6 = (int32_t)lround(64.0 * 0.5e6 * sin(w * i)),
                .vel_q10 = (int32_t)lround(1024.0 * 0.5e6 * w * cos(w * i)),
                .acc_q10 = -(int32_t)lround(1024.0 * 0.5e6 * w * w * sin(w * i)),
                .actual_q6 = (int32_t)lround(64.0 * 0.5e6 * sin(w * at)),
            };
            if (i == 0) {
                cam_servo_start_isr(&servo, &c, &in);
            }
            (void)cam_servo_step_isr(&servo, &c, &in);
            TEST_ASSERT_DOUBLE_WITHIN(i < 2 ? 100.0 : cases[k].most_nm, 0.0, servo.error_q6 / 64.0);
        }
    }
}
