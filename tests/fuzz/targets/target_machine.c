// SPDX-License-Identifier: Apache-2.0
// Any machine that a builder could set up: its rate, limits, gains and jerks are drawn, and a value
// that is refused stays at its default. Its drives are those that it is configured for, and nothing
// fails but stops and drives without power. So it may have no fault of its own, whatever the
// operator does.
#include "cam_machine.h" // cam_machine_jog
#include "fuzz_bytes.h"
#include "fuzz_draw.h"
#include "fuzz_expect.h"
#include "fuzz_mutate.h"
#include "fuzz_orders.h"
#include "fuzz_rig.h"
#include "cam_feasible.h" // cam_gains_log2_window
#include "hal_host.h"     // hal_host
#include <math.h>         // fmax, ldexp
#include <stdlib.h>       // abs

enum { head_bytes = 4 + fuzz_draw_bytes, most_ticks = 8000 };

/// [rev/min / 1000] slower, and the spindle would count as standing
enum { least_mrpm = 30000 };

/// @return [rev/min / 1000] at which the drive of U still follows an ellipse: k1 times the angular
///         frequency of two swings per turn is 1
static int64_t followed_mrpm(int32_t k1_ns)
{
    return k1_ns > 0 ? INT64_C(4774648292756) / k1_ns : INT32_MAX;
}

/// @return [nm] where the command of U comes to rest at most when it is braked at the worst angle,
///         MATHS.md (211)
static double stopped_nm(int64_t mrpm)
{
    const cam_params_t *p = &fuzz_rig.machine.params;
    const cam_table_t *t = &fuzz_rig.machine.table;
    const uint32_t hz = fuzz_rig.judge.tick_hz;
    const double omega = (double)mrpm * 6.283185307 / 60000.0;
    const double window_s = ldexp(1.0, (int)cam_gains_log2_window(p, hal_axis_u, hz)) / hz;
    const double k1 = p->k1_ns * 1e-9;
    const double k2 = p->k2_us2 * 1e-12;
    const double u1 = t->u1_peak_nm_per_rad * omega;
    const double u2 = t->u2_peak_nm_per_rad2 * omega * omega;
    const double u3 = t->u3_peak_nm_per_rad3 * omega * omega * omega;
    const double inwards = fmax(abs(t->u_min_nm), abs(t->u_max_nm)) + k1 * u1 + k2 * u2;
    const double speed = u1 + k1 * u2 + k2 * u3;
    const double a = 1e6 * p->u_acceleration_mm_per_s2;
    const double later = speed + a * window_s / 2.0;
    return inwards + speed * window_s / 2.0 + later * later / (2.0 * a);
}

/// The spindle turns at a share of the highest speed at which the machine can cut the part, its
/// drive follows and U can be stopped within its stroke: the feed-forward of a slower drive, and a
/// stop with less jerk, would have to leave the stroke (README.md).
static void draw_spindle(uint8_t share)
{
    cam_machine_t *m = &fuzz_rig.machine;
    const int64_t highest_mrpm = cam_machine_highest_mrpm(m);
    const int64_t by_drive_mrpm = followed_mrpm(m->params.k1_ns);
    const int64_t most_mrpm = highest_mrpm < by_drive_mrpm ? highest_mrpm : by_drive_mrpm;
    int64_t mrpm = most_mrpm * (share + 1) / 256;
    while (mrpm > least_mrpm && stopped_nm(mrpm) > m->params.u_stroke_nm / 2) {
        mrpm -= mrpm / 8 + 1;
    }
    const int32_t least_spindle = mrpm > least_mrpm ? (int32_t)mrpm : least_mrpm;
    fuzz_try(cam_machine_set_param(m, cam_param_spindle_mrpm, least_spindle));
    fuzz_rig_tick();
    const double alpha_rpm = m->params.spindle_acceleration_mrad_per_s2 * 60.0 / 6283.185307;
    fuzz_rig.lathe.ramp_rpm = alpha_rpm / hal_host.tick_hz;
}

static void set_up(fuzz_bytes_t *b)
{
    const uint8_t how = fuzz_u8(b);
    fuzz_rig_start((fuzz_start_t){.tick_hz = fuzz_rig_hz(how),
                                  .part = how / 16u % fuzz_rig_n_parts,
                                  .has_button = fuzz_u8(b) == 1u,
                                  .state = cam_state_off});
    fuzz_rig.judge.is_drawn = true;
    const uint8_t share = fuzz_u8(b);
    (void)fuzz_u8(b);
    // What a coarse encoder makes of the set-points is a fault of the encoder.
    fuzz_rig_encoder(1 << 24);
    fuzz_try(cam_machine_set_param(&fuzz_rig.machine, cam_param_counts_per_turn, 1 << 24));
    fuzz_rig_tick();
    fuzz_draw_all(b);
    draw_spindle(share);
    // The lag of Z is compensated while its speed stays the same, so it may leave its margin.
    const uint32_t by_lag = fuzz_rig.machine.params.xz_lag_ns > 0 ? CAM_FAULT_BIT(z_range) : 0u;
    fuzz_rig.judge.may_fault =
        CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(bus) | by_lag;
}

/// Wait for the next state or for the end of a retract, not longer than n ticks, in which a look
/// now and then is enough.
static void await(uint32_t n)
{
    enum { look_ticks = 16 };
    const cam_state_t before = fuzz_rig_state();
    const bool was_out = fuzz_rig_record()->want.is_retracted;
    for (uint32_t i = 0; i < n && fuzz_orders_has_time(); i += (uint32_t)look_ticks) {
        fuzz_let_pass(look_ticks);
        if (fuzz_rig_state() != before || fuzz_rig_record()->want.is_retracted != was_out) {
            return;
        }
    }
}

/// Jog an axis on and on, as by a button that is held, up to the end of its travel.
/// @param n  [tenths of a second] at most
static void jog_on(hal_axis_t axis, int32_t um_per_s, uint32_t n)
{
    cam_machine_t *m = &fuzz_rig.machine;
    for (uint32_t i = 0; i < n && fuzz_orders_has_time(); i++) {
        fuzz_try_verdict(cam_machine_jog(m, axis, um_per_s));
        fuzz_rig.judge.n_alone = 0;
        fuzz_let_pass(fuzz_rig.judge.tick_hz / 10u);
        if (cam_machine_status(m).jog.end == cam_jog_limit) {
            return;
        }
    }
}

/// Jog to the end of the travel, by up to all the speed that there is: one beyond it is refused
/// with the most that is not.
static void jog_to_end(uint8_t which, uint16_t code)
{
    const hal_axis_t axis = (hal_axis_t)(which % hal_n_axes);
    const cam_verdict_t verdict = cam_machine_jog(&fuzz_rig.machine, axis, INT32_MAX);
    const int64_t wanted = (int64_t)verdict.value * (code >> 8) / 255;
    jog_on(axis, (int32_t)((which & 0x80u) != 0u ? -wanted : wanted), code % 32u + 1u);
}

static void carry_out(fuzz_order_t order)
{
    static const uint8_t mishaps[] = {fuzz_disturb_estop,  fuzz_disturb_drive, fuzz_disturb_bus,
                                      fuzz_disturb_button, fuzz_disturb_press, fuzz_disturb_key,
                                      fuzz_disturb_mend,   fuzz_disturb_mend};
    const uint8_t which = order.which;
    const uint16_t code = order.code;
    const int32_t value = (int16_t)code * 32;
    switch (order.what % 8u) {
    case 1:
        fuzz_usual(value);
        break;
    case 2:
        fuzz_command(which, value);
        break;
    case 3:
        await(code);
        break;
    case 4:
        fuzz_disturb(mishaps[which % sizeof mishaps], code);
        break;
    case 5:
        jog_to_end(which, code);
        break;
    default:
        fuzz_usual(value);
        await(code);
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_bytes_t b = {.at = data, .n = size};
    if (size < (size_t)head_bytes) {
        return -1;
    }
    set_up(&b);
    fuzz_orders_play(&b, most_ticks, carry_out);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
    return fuzz_mutate_orders(data, size, max_size, seed, head_bytes, fuzz_order_bytes);
}
