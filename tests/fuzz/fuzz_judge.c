// SPDX-License-Identifier: Apache-2.0
#include "fuzz_judge.h"
#include "fuzz_expect.h" // FUZZ_EXPECT
#include "hal_host.h"    // hal_host
#include <string.h>      // memset

/// Faults that may leave a drive without power: `drive` does at once, `u_runaway` within 5 ms, and
/// after `u_travel` U is held if it can be.
#define LET_GO (CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(u_runaway) | CAM_FAULT_BIT(u_travel))

enum { tolerance = 16 };    ///< the guard accepts a sixteenth beyond speed and acceleration
enum { rounding_nm = 8 };   ///< of set-points to whole nanometres, twice differenced
enum { learned_nm = 1000 }; ///< by which learning may move the command of U at once
enum { counts_nm = 30 };    ///< what the encoder's counts shake of the axes that follow it

static int64_t size_of(int64_t a)
{
    return a < 0 ? -a : a;
}

void fuzz_judge_begin(fuzz_judge_t *j, uint32_t tick_hz, int32_t rise_nm)
{
    memset(j, 0, sizeof *j);
    j->tick_hz = tick_hz;
    j->plan_ticks = (tick_hz + 1250u) / 2500u > 1u ? (tick_hz + 1250u) / 2500u : 1u;
    j->may_fault = UINT32_MAX;
    j->rise_nm = rise_nm;
    j->state = cam_state_off;
}

/// The arrows of cam_state.h. Between two plans a state may begin and end, so one that a plan
/// passes through is not always seen.
static bool may_follow(cam_state_t to, cam_state_t from, bool is_ordered, uint32_t faults)
{
    const uint32_t holding =
        CAM_FAULT_BIT(estop) | CAM_FAULT_BIT(drive) | CAM_FAULT_BIT(bus) | CAM_FAULT_BIT(late_tick);
    if (to == cam_state_fault && from == cam_state_off) {
        return is_ordered && (faults & holding) == 0u; // homing began with, say, no index
    }
#define TO(state) (1u << cam_state_##state)
    static const uint32_t from_to[cam_n_states] = {
        [cam_state_off] = TO(homing) | TO(manual),
        [cam_state_homing] = TO(ready) | TO(off),
        [cam_state_ready] = TO(engaging) | TO(rehearsing) | TO(identifying) | TO(off),
        [cam_state_engaging] = TO(cutting) | TO(holding) | TO(disengaging) | TO(ready),
        [cam_state_cutting] = TO(holding) | TO(disengaging),
        [cam_state_holding] = TO(cutting) | TO(disengaging),
        [cam_state_disengaging] = TO(ready),
        [cam_state_fault] = TO(off),
        [cam_state_rehearsing] = TO(engaging) | TO(ready),
        [cam_state_identifying] = TO(ready) | TO(off),
        [cam_state_manual] = TO(off),
    };
#undef TO
    return to == from || to == cam_state_fault || (from_to[from] >> to & 1u) != 0u;
}

/// With the swing and two windows of plans.
static uint32_t patience(const fuzz_judge_t *j)
{
    const double axes = fuzz_limits_patience(&j->limits, j->rise_nm) * 5.0 / 4.0;
    const double plans = (16.0 + 2.0 * fuzz_limits_steps) * j->plan_ticks;
    return (uint32_t)fuzz_less(axes + plans + j->tick_hz / 2.0, 4e9);
}

/// @return whether X and Z follow the spindle's angle
static bool is_geared(cam_state_t state)
{
    return state == cam_state_engaging || state == cam_state_cutting ||
           state == cam_state_holding || state == cam_state_disengaging ||
           state == cam_state_rehearsing;
}

/// A cut is judged by its set-points before it begins (cam_feasible.h). Two additions are not known
/// then: that of the feed-forward, and how far U continues when a fault or a stop takes it out of
/// its motion. Where they exceed the limits, U is commanded the nearest position within them, and
/// the fault `command` is latched.
/// @param faults  of this tick
/// @return faults that are not the machine's own
static uint32_t may_fault(const fuzz_judge_t *j, uint32_t faults)
{
    const bool is_led =
        (is_geared(j->state) || j->is_taken_out) && j->limits.gain_rounding_nm > 0.0;
    const bool is_leaving = j->state == cam_state_fault || (faults & j->may_fault) != 0u;
    return is_led || is_leaving ? j->may_fault | CAM_FAULT_BIT(command) : j->may_fault;
}

static void judge_state(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    const cam_want_t *want = &r->want;
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    const bool is_fault = want->state == cam_state_fault;
    const bool is_runaway = (want->faults & CAM_FAULT_BIT(u_runaway)) != 0u;
    j->n_runaway = is_runaway ? j->n_runaway + 1u : 0u;
    const uint32_t request = r->in.request & 0xFFu;
    const bool is_ordered = r->in.request != j->request &&
                            (request == cam_request_enable || request == cam_request_manual);
    FUZZ_EXPECT(may_follow(want->state, j->state, is_ordered, want->faults), "%s after %s",
                cam_state_name(want->state), cam_state_name(j->state));
    FUZZ_EXPECT(is_fault == (want->faults != 0u), "faults %x in %s", (unsigned)want->faults,
                cam_state_name(want->state));
    FUZZ_EXPECT(is_fault == ((hal_host.out.outputs & hal_out_fault) != 0u), "lamp in %s",
                cam_state_name(want->state));
    FUZZ_EXPECT(!is_fault || j->state != cam_state_fault || (j->faults & ~want->faults) == 0u,
                "fault %x is no longer latched", (unsigned)(j->faults & ~want->faults));
    if (want->state == cam_state_off) {
        FUZZ_EXPECT(!is_enabled, "enabled in off");
    } else if (!is_fault) {
        FUZZ_EXPECT(is_enabled, "no enable in %s", cam_state_name(want->state));
    } else {
        const bool may_drop = (want->faults & LET_GO) != 0u || want->is_retracted;
        const bool is_leaving = j->n_runaway > 0u && j->n_runaway <= j->tick_hz / 200u + 1u;
        const bool is_over = want->is_retracted || j->n_runaway > 0u;
        const bool must_drop =
            (want->faults & CAM_FAULT_BIT(drive)) != 0u || (is_over && !is_leaving);
        FUZZ_EXPECT(is_enabled || may_drop, "enable dropped before the retract ended");
        FUZZ_EXPECT(!is_enabled || !must_drop, "enabled in a fault without need");
        FUZZ_EXPECT(is_enabled <= j->was_enabled || j->state == cam_state_off,
                    "enable came back in a fault");
    }
    const uint32_t own = want->faults & ~j->faults & ~may_fault(j, want->faults);
    FUZZ_EXPECT(own == 0u, "fault %x of its own in %s", (unsigned)own, cam_state_name(j->state));
    const bool is_still =
        want->state == cam_state_off || want->state == cam_state_manual || is_fault;
    FUZZ_EXPECT(!is_still || hal_host.out.spindle_mrpm == 0, "the spindle is commanded %d in %s",
                (int)hal_host.out.spindle_mrpm, cam_state_name(want->state));
    FUZZ_EXPECT(size_of(hal_host.out.spindle_mrpm) <= j->limits.spindle_mrpm + 1,
                "the spindle is commanded %d", (int)hal_host.out.spindle_mrpm);
    const bool is_in_cut = want->state == cam_state_cutting || want->state == cam_state_holding;
    FUZZ_EXPECT(is_in_cut == ((hal_host.out.outputs & hal_out_in_cut) != 0u), "in_cut in %s",
                cam_state_name(want->state));
}

/// The drives come on only behind a press of the button that lasted neither too short nor too long
/// and came behind the last fault and emergency stop. A contact that bounces makes a press up to
/// 20 ms shorter or longer.
static void judge_button(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    const bool is_on = r->want.state != cam_state_off && r->want.state != cam_state_fault;
    const bool comes_on = j->state == cam_state_off && is_on;
    FUZZ_EXPECT(!j->has_button || !comes_on || j->is_pressed_right, "enabled without a press");
    const bool is_needed = r->want.state == cam_state_fault || (r->in.inputs & hal_in_estop) != 0u;
    const bool is_pressed = (r->in.inputs & hal_in_acknowledge) != 0u;
    const uint32_t ms = (uint32_t)((uint64_t)j->n_pressed * 1000u / j->tick_hz);
    if (is_needed) {
        j->is_pressed_right = false;
    } else if (!is_pressed && ms >= 25u && ms <= 2100u) {
        j->is_pressed_right = true;
    } else {
        // it stays what it was
    }
    // A press that was there before all was well is none.
    const bool is_counted = is_pressed && !is_needed && r->want.state == cam_state_off;
    const bool is_first = !j->was_pressed;
    j->n_pressed = is_counted && (is_first || j->n_pressed > 0u) ? j->n_pressed + 1u : 0u;
    j->was_pressed = is_pressed;
}

/// @return whether X and Z have the limits of the fault `command`
static bool is_loose(const fuzz_judge_t *j)
{
    return j->is_wild || j->is_angle_doubtful || (j->is_drawn && is_geared(j->state));
}

/// @return [nm per tick] what a jump of the encoder, a quarter turn at most, makes of the way of X
/// or Z, where it counts
static double unrest_nm(const fuzz_judge_t *j, uint32_t axis)
{
    return is_loose(j) ? j->limits.way_nm[axis] / 4.0 / j->plan_ticks : 0.0;
}

/// @return [nm] that X, which moves outwards when the fault comes, needs to brake
static double outwards_nm(const fuzz_judge_t *j)
{
    const fuzz_limits_t *l = &j->limits;
    const double v_nm = fuzz_more(j->step_nm[hal_axis_x], 0.0);
    const double window = (l->window[hal_axis_x] + 2.0) * j->plan_ticks;
    return v_nm * (v_nm / l->brake_nm[hal_axis_x] + window) +
           l->acceleration_nm[hal_axis_x] * window * j->plan_ticks;
}

/// In a fault the tool leaves the work within the stated time, and rests then.
static void judge_fault(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    if (r->want.state != cam_state_fault) {
        return;
    }
    if (j->state != cam_state_fault) {
        j->n_fault = 0;
        j->swing_on_q32 = size_of(hal_host.out.swing.vel_q32) * 2 * j->plan_ticks;
        j->patience = patience(j);
        j->fault_x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
        j->outwards_nm = outwards_nm(j);
    }
    j->n_fault++;
    if ((r->want.faults & LET_GO) != 0u) {
        return; // a drive without power goes nowhere
    }
    FUZZ_EXPECT(j->n_fault <= j->patience || r->want.is_retracted,
                "the retract lasts longer than %u ticks", (unsigned)j->patience);
    const int64_t off_nm = (int64_t)hal_host.out.axis[hal_axis_x].pos_nm - j->fault_x_nm;
    const fuzz_limits_t *l = &j->limits;
    const double v_nm = l->speed_nm[hal_axis_x] + unrest_nm(j, (uint32_t)hal_axis_x);
    const double window = ((double)fuzz_limits_steps + 2.0) * j->plan_ticks;
    const double brakes_nm = v_nm * (v_nm / l->brake_nm[hal_axis_x] + window);
    FUZZ_EXPECT((double)off_nm >= -brakes_nm, "X enters the work by %lld nm in a fault",
                (long long)-off_nm);
    // X of a drawn machine has no home: its travel is given in the coordinates of the port.
    const double end_nm = fuzz_more(l->x_high_nm, j->fault_x_nm) + j->outwards_nm + rounding_nm;
    const int32_t x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    FUZZ_EXPECT(!j->is_drawn || x_nm <= end_nm, "X goes to %d nm in a fault, its travel to %g",
                (int)x_nm, end_nm);
}

/// @return [nm per tick] highest speed that an axis may be commanded
static double most_step_nm(const fuzz_judge_t *j, uint32_t axis)
{
    const fuzz_limits_t *l = &j->limits;
    const bool is_u = axis == (uint32_t)hal_axis_u;
    const double own_nm = is_u ? l->commanded_step_nm : l->speed_nm[axis];
    const double shaken_nm = is_u ? 0.0 : unrest_nm(j, axis);
    const double rounded_nm = counts_nm + (is_u ? l->gain_rounding_nm : 0.0);
    return own_nm * (tolerance + 1) / tolerance + shaken_nm + rounded_nm;
}

/// @return [nm per tick^2] by how much the command of U changes its step: with gains an excursion
/// that no window bounds is the controller's to bound, in its wider limit, which is also the one
/// of the fault `command`. The first tick of a fault may take back the change of the last step
static double most_change_of_u_nm(const fuzz_judge_t *j)
{
    const fuzz_limits_t *l = &j->limits;
    const bool is_cut_off = (j->faults & CAM_FAULT_BIT(command)) != 0u;
    const bool is_supervised =
        j->is_wild || is_cut_off || (l->gain_rounding_nm > 0.0 && is_geared(j->state));
    const bool is_first = j->state == cam_state_fault && j->n_fault == 1u;
    const double back_nm = is_first ? (double)size_of(j->u_change_nm) : 0.0;
    const double usual_nm = l->commanded_change_nm * (tolerance + 1) / tolerance +
                            l->gain_rounding_nm + rounding_nm + (is_supervised ? learned_nm : 0);
    return usual_nm + (back_nm > l->acceleration_nm[hal_axis_u] ? back_nm : 0.0);
}

/// The commanded speeds of X and Z change from plan to plan by their acceleration; the controller
/// accepts twice that and twice the unrest; more is the fault `command`.
static double most_change_nm(const fuzz_judge_t *j, uint32_t axis)
{
    // After a late tick the axes make up for what the spindle has turned meanwhile.
    const double late_nm = j->n_off_time > 0u ? 2.0 * (double)size_of(j->step_nm[axis]) : 0.0;
    if (axis == (uint32_t)hal_axis_u) {
        return most_change_of_u_nm(j) + late_nm;
    }
    const double own_nm = j->limits.acceleration_nm[axis] * j->plan_ticks;
    const double accepted_nm =
        is_loose(j) ? 2.0 * (own_nm + unrest_nm(j, axis)) : own_nm * (tolerance + 1) / tolerance;
    return accepted_nm + late_nm + counts_nm * 2;
}

/// While X leaves the work in a fault its acceleration changes by its jerk, over the window of its
/// motion. From plan to plan, at whichever of its ticks, so the ticks of one plan are kept.
static void judge_jerk(fuzz_judge_t *j, int64_t change_nm, bool is_judged)
{
    const uint32_t before =
        (j->at + (uint32_t)fuzz_judge_ticks - j->plan_ticks + 1u) % (uint32_t)fuzz_judge_ticks;
    const fuzz_limits_t *l = &j->limits;
    const double most_nm =
        2.0 * l->acceleration_nm[hal_axis_x] * j->plan_ticks / l->window[hal_axis_x];
    const int64_t jerk_nm = change_nm - j->change_nm[before];
    j->at = (j->at + 1u) % (uint32_t)fuzz_judge_ticks;
    j->change_nm[j->at] = (int32_t)change_nm;
    FUZZ_EXPECT(!is_judged || (double)size_of(jerk_nm) <=
                                  most_nm * (tolerance + 1) / tolerance + 2 * rounding_nm,
                "X jerks by %lld nm of %g in a fault", (long long)jerk_nm, most_nm);
}

/// A U without feed-forward is commanded its set-point, whose acceleration changes by its jerk
/// where U moves by time and the fault `command` does not cut the motion off.
static void judge_jerk_of_u(const fuzz_judge_t *j, uint32_t faults, int64_t jerk_nm)
{
    const fuzz_limits_t *l = &j->limits;
    const bool is_by_time = j->state == cam_state_homing ||
                            (j->state == cam_state_fault && j->n_fault > 4u * j->plan_ticks &&
                             (faults & CAM_FAULT_BIT(command)) == 0u);
    const double most_nm = 2.0 * l->acceleration_nm[hal_axis_u] / l->window[hal_axis_u];
    FUZZ_EXPECT(
        !is_by_time || j->is_wild || l->gain_rounding_nm > 0.0 || j->n_moved < 3u ||
            (double)size_of(jerk_nm) <= most_nm * (tolerance + 1) / tolerance + 2 * rounding_nm,
        "U jerks by %lld nm of %g in %s", (long long)jerk_nm, most_nm, cam_state_name(j->state));
}

/// @return [ticks] in which an axis that is led by hand comes to rest: with a quarter of the
/// smallest acceleration and the longest window that held meanwhile, after the time that a jog
/// waits
static double rest_ticks(const fuzz_judge_t *j, uint32_t axis)
{
    const fuzz_limits_t *l = &j->limits;
    const double brake = 4.0 * l->speed_nm[axis] / l->brake_nm[axis];
    return j->tick_hz / 4.0 + 1.25 * brake + (l->longest[axis] + 4.0) * j->plan_ticks;
}

/// By hand an axis moves only while its master lives; in the work X stays within its travel.
static void judge_way(const fuzz_judge_t *j, const cam_tick_record_t *r, uint32_t axis,
                      int64_t step_nm)
{
    const bool is_alone = j->state == cam_state_manual && j->n_alone > rest_ticks(j, axis);
    FUZZ_EXPECT(!is_alone || step_nm == 0, "axis %u moves by %lld nm without a master",
                (unsigned)axis, (long long)step_nm);
    if (axis == (uint32_t)hal_axis_x && is_geared(r->want.state) && !j->is_wild) {
        const double x_nm = (double)hal_host.out.axis[axis].pos_nm + j->x_shift_nm;
        const bool goes_out = x_nm < j->limits.x_low_nm - rounding_nm
                                  ? step_nm < 0
                                  : x_nm > j->limits.x_high_nm + rounding_nm && step_nm > 0;
        FUZZ_EXPECT(!goes_out, "X leaves its travel at %.0f nm in %s", x_nm,
                    cam_state_name(r->want.state));
    }
}

static void judge_axes(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    j->n_moved = is_enabled && j->was_enabled ? j->n_moved + 1u : 0u;
    j->n_off_time = r->angle.is_off_time ? 3u + 3u * j->plan_ticks
                                         : j->n_off_time - (j->n_off_time > 0u ? 1u : 0u);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int32_t commanded_nm = hal_host.out.axis[i].pos_nm;
        const int64_t step_nm = (int64_t)commanded_nm - j->commanded_nm[i];
        const int64_t change_nm = step_nm - j->step_nm[i];
        const bool is_led = i == (uint32_t)hal_axis_z && j->is_z_led;
        if (j->n_moved > 0u && !is_led) {
            FUZZ_EXPECT((double)size_of(step_nm) <= most_step_nm(j, i),
                        "axis %u steps by %lld nm of %g in %s", (unsigned)i, (long long)step_nm,
                        most_step_nm(j, i), cam_state_name(r->want.state));
        }
        if (j->n_moved > 0u && !is_led) {
            judge_way(j, r, i, step_nm);
        }
        // An X over a measured Z follows what is measured.
        const bool is_over_led = i != (uint32_t)hal_axis_u && j->is_z_led;
        if (j->n_moved > 1u && !is_over_led) {
            FUZZ_EXPECT((double)size_of(change_nm) <= most_change_nm(j, i),
                        "axis %u changes its step by %lld nm of %g in %s", (unsigned)i,
                        (long long)change_nm, most_change_nm(j, i), cam_state_name(r->want.state));
        }
        if (i == (uint32_t)hal_axis_u) {
            judge_jerk_of_u(j, r->want.faults, change_nm - j->u_change_nm);
            j->u_change_nm = change_nm;
        }
        if (i == (uint32_t)hal_axis_x) {
            const bool is_leaving = j->n_moved > 1u && r->want.state == cam_state_fault &&
                                    j->n_fault > 4u * j->plan_ticks && !j->is_wild;
            judge_jerk(j, change_nm, is_leaving);
        }
        j->commanded_nm[i] = commanded_nm;
        j->step_nm[i] = (int32_t)step_nm;
    }
    const int32_t home_nm = r->in.actual_nm[hal_axis_u] - hal_host.in.axis_nm[hal_axis_u];
    const int64_t u_nm = (int64_t)hal_host.out.axis[hal_axis_u].pos_nm + home_nm;
    FUZZ_EXPECT(!is_enabled || size_of(u_nm) <= j->limits.stroke_nm + 1,
                "U is commanded %lld nm of %lld in %s", (long long)u_nm,
                (long long)j->limits.stroke_nm, cam_state_name(r->want.state));
    // A drawn machine may swing in a few plans, and then brakes a plan late.
    const int64_t on_q32 = r->want.state == cam_state_fault && j->is_drawn ? j->swing_on_q32 : 0;
    FUZZ_EXPECT(!is_enabled ||
                    size_of(hal_host.out.swing.pos_q32) <= j->limits.swing_q32 + on_q32 + 1000,
                "the swing is commanded %d", (int)hal_host.out.swing.pos_q32);
    j->was_enabled = is_enabled;
}

void fuzz_judge_tick(fuzz_judge_t *j, const cam_params_t *p, uint32_t version,
                     const cam_tick_record_t *r)
{
    if (j->version != version || j->state == cam_state_off) {
        const fuzz_limits_t now = fuzz_limits(p, j->tick_hz, j->plan_ticks);
        j->version = version;
        j->is_z_led = p->z_is_measured != 0;
        if (j->state == cam_state_off) {
            j->limits = now;
            j->is_angle_doubtful = false;
        } else {
            fuzz_limits_widen(&j->limits, &now);
        }
    }
    judge_state(j, r);
    judge_button(j, r);
    judge_fault(j, r);
    const cam_state_t before = j->state;
    j->state = r->want.state;
    const bool is_stopped = before == cam_state_engaging || before == cam_state_rehearsing;
    j->is_taken_out = j->state == cam_state_ready && (is_stopped || j->is_taken_out);
    j->faults = r->want.faults;
    judge_axes(j, r);
    j->request = r->in.request;
    j->n_alone++;
}
