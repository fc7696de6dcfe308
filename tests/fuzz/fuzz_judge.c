// SPDX-License-Identifier: Apache-2.0
#include "fuzz_judge.h"
#include "fuzz_expect.h" // FUZZ_EXPECT
#include "hal_host.h"    // hal_host
#include <string.h>      // memset

enum { tolerance = 16 };         ///< the guard accepts a sixteenth beyond speed and acceleration
enum { rounding_nm = 8 };        ///< of set-points to whole nanometres, twice differenced
enum { table_feed_nm = 100000 }; ///< of the tables of fuzz_rig.c
enum { counts_nm = 30 };         ///< what the encoder's counts shake of the axes that follow it

static int64_t most(int64_t a, int64_t b)
{
    return a > b ? a : b;
}

static int64_t size_of(int64_t a)
{
    return a < 0 ? -a : a;
}

static fuzz_limits_t limits_of(const cam_params_t *p, int64_t hz)
{
    const int32_t speed_um_per_s[] = {p->u_speed_um_per_s, p->x_speed_um_per_s,
                                      p->z_speed_um_per_s};
    const int32_t acceleration_mm_per_s2[] = {
        p->u_acceleration_mm_per_s2, p->x_acceleration_mm_per_s2, p->z_acceleration_mm_per_s2};
    fuzz_limits_t l = {
        .stroke_nm = p->u_stroke_nm / 2,
        .clearance_nm = p->x_clearance_nm,
        .feed_nm = most(p->feed_nm, table_feed_nm),
        .spindle_mrpm = p->spindle_limit_mrpm,
        .swing_q32 = p->swing_range_mdeg * INT64_C(4294967296) / 360000,
    };
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        l.speed_nm[i] = speed_um_per_s[i] * INT64_C(1000) / hz + 1;
        l.acceleration_nm[i] = acceleration_mm_per_s2[i] * INT64_C(1000000) / hz / hz + 1;
    }
    return l;
}

static void loosen(fuzz_limits_t *l, const fuzz_limits_t *now)
{
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        l->speed_nm[i] = most(l->speed_nm[i], now->speed_nm[i]);
        l->acceleration_nm[i] = most(l->acceleration_nm[i], now->acceleration_nm[i]);
    }
    l->stroke_nm = most(l->stroke_nm, now->stroke_nm);
    l->feed_nm = most(l->feed_nm, now->feed_nm);
    l->clearance_nm = most(l->clearance_nm, now->clearance_nm);
    l->spindle_mrpm = most(l->spindle_mrpm, now->spindle_mrpm);
    l->swing_q32 = most(l->swing_q32, now->swing_q32);
}

void fuzz_judge_begin(fuzz_judge_t *j, uint32_t tick_hz, int32_t rise_nm)
{
    memset(j, 0, sizeof *j);
    j->tick_hz = tick_hz;
    j->plan_ticks = tick_hz / 2500u > 1u ? tick_hz / 2500u : 1u;
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

/// @return [ticks] that an axis needs at most to brake from its highest speed, go a way and come to
/// rest there: with a ramp at both ends, and a plan for every change of mind
static int64_t ticks_for(int64_t way_nm, int64_t speed_nm, int64_t acceleration_nm)
{
    const int64_t brake = speed_nm / acceleration_nm + 1;
    const int64_t ramp = 2 * brake; // up and down again, where the way is long enough for it
    const int64_t back_nm = speed_nm * brake;
    return brake + ramp + (way_nm + 2 * back_nm) / speed_nm + 1;
}

/// FAULTS.md: U by at most its stroke, X by its clearance and what a lobe rises, Z to rest.
static uint32_t patience(const fuzz_judge_t *j)
{
    const fuzz_limits_t *l = &j->limits;
    const int64_t way_nm[hal_n_axes] = {2 * l->stroke_nm + j->rise_nm, l->clearance_nm + j->rise_nm,
                                        0};
    int64_t ticks = 0;
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        ticks = most(ticks, ticks_for(way_nm[i], l->speed_nm[i], l->acceleration_nm[i]));
    }
    return (uint32_t)(ticks * 5 / 4) + 16u * j->plan_ticks + j->tick_hz / 2u; // and the swing's
}

static void judge_state(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    const cam_want_t *want = &r->want;
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    const bool is_fault = want->state == cam_state_fault;
    const uint32_t no_power = CAM_FAULT_BIT(drive);
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
        const bool may_drop = (want->faults & no_power) != 0u || want->is_retracted;
        FUZZ_EXPECT(is_enabled || may_drop, "enable dropped before the retract ended");
        FUZZ_EXPECT(!is_enabled || !may_drop, "enabled in a fault without need");
        FUZZ_EXPECT(is_enabled <= j->was_enabled || j->state == cam_state_off,
                    "enable came back in a fault");
    }
    const bool is_still =
        want->state == cam_state_off || want->state == cam_state_manual || is_fault;
    FUZZ_EXPECT(!is_still || hal_host.out.spindle_mrpm == 0, "the spindle is told %d in %s",
                (int)hal_host.out.spindle_mrpm, cam_state_name(want->state));
    FUZZ_EXPECT(size_of(hal_host.out.spindle_mrpm) <= j->limits.spindle_mrpm + 1,
                "the spindle is told %d", (int)hal_host.out.spindle_mrpm);
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

/// In a fault the tool leaves the work within the stated time, and rests then.
static void judge_fault(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    if (r->want.state != cam_state_fault) {
        return;
    }
    if (j->state != cam_state_fault) {
        j->n_fault = 0;
        j->was_by_hand = j->state == cam_state_manual;
        j->patience = patience(j);
        j->fault_x_nm = hal_host.out.axis[hal_axis_x].pos_nm;
    }
    j->n_fault++;
    if ((r->want.faults & CAM_FAULT_BIT(drive)) != 0u) {
        return; // a drive without power goes nowhere
    }
    FUZZ_EXPECT(j->n_fault <= j->patience || r->want.is_retracted,
                "the retract lasts longer than %u ticks", (unsigned)j->patience);
    const int64_t off_nm = (int64_t)hal_host.out.axis[hal_axis_x].pos_nm - j->fault_x_nm;
    const int64_t brake_nm = j->limits.speed_nm[hal_axis_x] * j->limits.speed_nm[hal_axis_x] /
                             j->limits.acceleration_nm[hal_axis_x];
    FUZZ_EXPECT(off_nm >= -brake_nm - j->limits.speed_nm[hal_axis_x] * j->plan_ticks * 2,
                "X enters the work by %lld nm in a fault", (long long)-off_nm);
}

/// What X and Z are told may change by twice their acceleration, and twice by what a jump of the
/// encoder, a quarter turn at most, makes of the feed; beyond that it is the fault `command`.
static int64_t supervised_nm(const fuzz_judge_t *j, uint32_t axis)
{
    const int64_t plan = (int64_t)j->plan_ticks;
    return 2 * (j->limits.acceleration_nm[axis] * plan + j->limits.feed_nm / 4 / plan);
}

static int64_t most_change_nm(const fuzz_judge_t *j, uint32_t axis)
{
    // X and Z change their speed from plan to plan, U in the tick but by hand.
    const bool is_u = axis == (uint32_t)hal_axis_u;
    const bool is_by_tick =
        is_u && j->state != cam_state_manual && !(j->state == cam_state_fault && j->was_by_hand);
    const int64_t ticks = is_by_tick ? 1 : (int64_t)j->plan_ticks;
    const int64_t own_nm = j->limits.acceleration_nm[axis] * ticks * (tolerance + 1) / tolerance;
    const bool is_loose = j->is_wild || j->is_angle_doubtful;
    const int64_t wild_nm = j->is_wild ? 2 * j->limits.speed_nm[axis] : own_nm;
    const int64_t accepted_nm = is_u ? wild_nm : is_loose ? supervised_nm(j, axis) : own_nm;
    // After a late tick the axes make up for what the spindle has turned meanwhile.
    const int64_t late_nm = j->n_off_time > 0u ? 2 * size_of(j->step_nm[axis]) : 0;
    return accepted_nm + late_nm + (is_by_tick ? rounding_nm : counts_nm * 2);
}

/// While X leaves the work in a fault its acceleration changes by its jerk: where none is set, over
/// 6.4 ms, which whole plans and a power of two make at least 3.2 ms of. From plan to plan, at
/// whichever of its ticks, so the ticks of one plan are kept.
static void judge_jerk(fuzz_judge_t *j, int64_t change_nm, bool is_judged)
{
    const uint32_t before =
        (j->at + (uint32_t)fuzz_judge_ticks - j->plan_ticks + 1u) % (uint32_t)fuzz_judge_ticks;
    const int64_t plan = (int64_t)j->plan_ticks;
    const int64_t plans = most(1, (int64_t)j->tick_hz * 32 / 10000 / plan);
    const int64_t most_nm = 2 * j->limits.acceleration_nm[hal_axis_x] * plan / plans;
    const int64_t jerk_nm = change_nm - j->change_nm[before];
    j->at = (j->at + 1u) % (uint32_t)fuzz_judge_ticks;
    j->change_nm[j->at] = (int32_t)change_nm;
    FUZZ_EXPECT(!is_judged ||
                    size_of(jerk_nm) <= most_nm * (tolerance + 1) / tolerance + 2 * rounding_nm,
                "X jerks by %lld nm of %lld in a fault", (long long)jerk_nm, (long long)most_nm);
}

static void judge_axes(fuzz_judge_t *j, const cam_tick_record_t *r)
{
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    j->n_moved = is_enabled && j->was_enabled ? j->n_moved + 1u : 0u;
    j->n_off_time = r->angle.is_off_time ? 3u + 3u * j->plan_ticks
                                         : j->n_off_time - (j->n_off_time > 0u ? 1u : 0u);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        const int32_t told_nm = hal_host.out.axis[i].pos_nm;
        const int64_t step_nm = (int64_t)told_nm - j->told_nm[i];
        const int64_t change_nm = step_nm - j->step_nm[i];
        const bool is_led = i == (uint32_t)hal_axis_z && j->is_z_led;
        if (j->n_moved > 0u && !is_led) {
            FUZZ_EXPECT(size_of(step_nm) <=
                            j->limits.speed_nm[i] * (tolerance + 1) / tolerance + counts_nm,
                        "axis %u steps by %lld nm of %lld in %s", (unsigned)i, (long long)step_nm,
                        (long long)j->limits.speed_nm[i], cam_state_name(r->want.state));
        }
        // An X over a measured Z follows what is measured.
        const bool is_over_led = i != (uint32_t)hal_axis_u && j->is_z_led;
        if (j->n_moved > 1u && !is_over_led) {
            FUZZ_EXPECT(size_of(change_nm) <= most_change_nm(j, i),
                        "axis %u changes its step by %lld nm of %lld in %s", (unsigned)i,
                        (long long)change_nm, (long long)most_change_nm(j, i),
                        cam_state_name(r->want.state));
        }
        if (i == (uint32_t)hal_axis_x) {
            const bool is_leaving = j->n_moved > 1u && r->want.state == cam_state_fault &&
                                    j->n_fault > 4u * j->plan_ticks && !j->is_wild;
            judge_jerk(j, change_nm, is_leaving);
        }
        j->told_nm[i] = told_nm;
        j->step_nm[i] = (int32_t)step_nm;
    }
    const int32_t home_nm = r->in.actual_nm[hal_axis_u] - hal_host.in.axis_nm[hal_axis_u];
    const int64_t u_nm = (int64_t)hal_host.out.axis[hal_axis_u].pos_nm + home_nm;
    FUZZ_EXPECT(!is_enabled || size_of(u_nm) <= j->limits.stroke_nm + 1,
                "U is told %lld nm of %lld in %s", (long long)u_nm, (long long)j->limits.stroke_nm,
                cam_state_name(r->want.state));
    FUZZ_EXPECT(!is_enabled || size_of(hal_host.out.swing.pos_q32) <= j->limits.swing_q32 + 1000,
                "the swing is told %d", (int)hal_host.out.swing.pos_q32);
    j->was_enabled = is_enabled;
}

void fuzz_judge_tick(fuzz_judge_t *j, const cam_params_t *p, uint32_t version,
                     const cam_tick_record_t *r)
{
    if (j->version != version || j->state == cam_state_off) {
        const fuzz_limits_t now = limits_of(p, j->tick_hz);
        j->version = version;
        j->is_z_led = p->z_is_measured != 0;
        if (j->state == cam_state_off) {
            j->limits = now;
            j->is_angle_doubtful = false;
        } else {
            loosen(&j->limits, &now);
        }
    }
    judge_state(j, r);
    judge_button(j, r);
    judge_fault(j, r);
    const cam_state_t before = j->state;
    j->state = r->want.state;
    judge_axes(j, r);
    j->faults = r->want.faults;
    j->request = r->in.request;
    j->n_visits[r->want.state] += before != r->want.state ? 1u : 0u;
}
