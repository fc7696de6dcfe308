// SPDX-License-Identifier: Apache-2.0
#include "sim_cut.h"
#include "cam_feasible.h" // cam_derived_limits_averaging_mrpm
#include "sim_cut_pass.h" // sim_cut_next_pass
#include "sim_units.h"    // sim_abs, sim_clamp
#include <math.h>         // lround

/// A real main loop does its background work whenever the interrupt leaves time. Here it is rare,
/// since a kilobyte of CRC costs as much as 10 ticks: a damaged table of 16 KB is found within 0.8
/// s at 20 kHz.
enum { background_polls = 64 };

cam_status_t sim_cut_status(const sim_cut_t *cut)
{
    return cam_machine_status(&cut->firmware.machine);
}

uint32_t sim_cut_lobe_without_turn(const sim_cut_t *cut)
{
    uint32_t i = 0;
    while (i < cut->session.design.lobes.n_lobes &&
           cut->session.lobes.gauge[i].n >= sim_lobe_dexels) {
        i++;
    }
    return i;
}

bool sim_cut_is_whole(const sim_cut_t *cut)
{
    // A cut with measured Z also ends with a stop, which is not an early end.
    return !cut->is_stopped || cut->session.cut_turns >= sim_cut_planned_turns(cut);
}

bool sim_cut_is_gauged(const sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    if (s->work.n == 0u || !sim_cut_is_whole(cut)) {
        return s->work.n > 0u;
    }
    return s->design.shape == sim_shape_lobes
               ? sim_cut_lobe_without_turn(cut) == s->design.lobes.n_lobes
               : sim_session_zone_without_sample(s) == NULL && sim_bands_are_done(&s->design.bands);
}

bool sim_cut_is_good(const sim_cut_t *cut)
{
    return cut->end == sim_cut_done && sim_cut_is_gauged(cut) &&
           sim_session_is_within(&cut->session) && sim_cut_left_stock(cut);
}

double sim_cut_rpm(const sim_cut_t *cut)
{
    return cut->feasibility.speed_mrpm * 1e-3;
}

double sim_cut_averaging_rpm(const sim_cut_t *cut)
{
    if (cut->session.table.speed.knots != NULL) {
        return 0.0;
    }
    const uint32_t tick_hz = (uint32_t)cut->session.options.config.lathe.tick_hz;
    return cam_derived_limits_averaging_mrpm(&cut->params, cut->feasibility.speed_mrpm, tick_hz) *
           1e-3;
}

bool sim_cut_is_loop_assumed(const sim_cut_t *cut)
{
    const sim_drive_config_t *u = &cut->session.options.config.lathe.drive[hal_axis_u];
    return u->kind == sim_drive_force && cut->params.servo_measured == 0;
}

const char *sim_cut_end_name(const sim_cut_t *cut)
{
    static const char *const name[] = {"running", "done",    "fault",
                                       "timeout", "refused", "unsteady"};
    return cut->end == sim_cut_done && cut->is_stopped ? "stopped" : name[cut->end];
}

/// Measure the removal of a skirt while cutting. Not judged are turns with rising or falling feed,
/// the turn after them, whose chips the rising feed left, the first turn on a part that the tool
/// enters along Z, and ring-helices. @return true when a slice was finished
static bool measure_removal(sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    const bool is_full = !sim_cut_has_rings(cut) && s->cut_turns > cut->full_first_turn &&
                         sim_abs(sim_session_turn(s) - s->touched_at_turn) > 1.0 &&
                         s->cut_turns < cut->full_last_turn;
    const double sense = s->table.direction; // the measurement needs a rising angle
    cut->removal.config.blank_mm = s->work.blank_mm;
    if (s->band_feed_mm > 0.0) {
        cut->removal.config.feed_mm = s->band_feed_mm;
    }
    const double radius_mm = s->place == sim_place_air ? s->work.blank_mm : s->radius_mm;
    const bool has_slice = sim_removal_touch(&cut->removal, s->at.t_s, sense * sim_session_turn(s),
                                             s->z_mm, radius_mm, is_full && !cut->is_stopped);
    cut->removal.slice.turn *= has_slice ? sense : 1.0; // back to the drawing's angle
    return has_slice;
}

/// Add the sample to the error of its turn; lobes only while cutting, since U alone is not their
/// shape.
/// @param n_before  samples counted before
static void count_turn(sim_cut_t *cut, uint64_t n_before)
{
    const sim_session_t *s = &cut->session;
    const double turn = sim_session_turn(s);
    if (cut->state == cam_state_rehearsing && s->design.shape != sim_shape_lobes) {
        sim_turns_rehearse(&cut->turns, turn, s->at.u_nm * 1e-3, s->exact_mm * 1e3);
    } else if (s->work.n > n_before) {
        sim_turns_touch(&cut->turns, turn, (s->radius_mm - s->exact_mm) * 1e3);
    } else if (cut->state != cam_state_cutting) {
        sim_turns_rest(&cut->turns, turn, cut->state == cam_state_engaging);
    }
}

/// Evaluate the tool's motion in the tick, and the state in which a fault occurred.
static void observe(sim_cut_t *cut)
{
    sim_session_t *s = &cut->session;
    const cam_state_t state = cut->firmware.state;
    const bool is_cutting = state == cam_state_cutting || state == cam_state_holding;
    const sim_sample_t at = sim_lathe_sample(&cut->port.lathe, cut->port.time_s);
    if (state == cam_state_fault && cut->fault_s < 0.0) {
        cut->fault_s = cut->port.time_s;
        cut->fault_turn = s->part_turn;
        cut->fault_z_mm = s->z_mm;
        cut->fault_state = cut->state; // state of the previous tick
    }
    cut->state = state;
    const uint64_t n_before = s->work.n;
    sim_session_touch(s, &at, is_cutting, cut->firmware.following_nm);
    count_turn(cut, n_before);
    sim_lathe_bite(&cut->port.lathe, sim_session_depth_mm(s));
    cut->has_slice = s->is_cutting && s->design.shape != sim_shape_lobes && measure_removal(cut);
}

static void operator_stop(sim_cut_t *cut)
{
    cut->is_stopped = cam_machine_stop(&cut->firmware.machine) == cam_ok || cut->is_stopped;
}

/// Process the answer to a command. If the controller is busy, the command is repeated later.
static void take_answer(sim_cut_t *cut, cam_err_t err)
{
    if (err != cam_ok && err != cam_err_busy) {
        cut->refusal = err;
        cut->end = sim_cut_refused;
    }
}

/// Apply an operator's change during the cut. @return cam_err_command for other kinds
static cam_err_t operator_changes(cam_machine_t *m, const sim_inject_t *what)
{
    switch (what->kind) {
    case sim_inject_hold:
        return cam_machine_hold(m);
    case sim_inject_resume:
        return cam_machine_resume(m);
    case sim_inject_feed_override:
        return cam_machine_set_param(m, cam_param_feed_override_ppm,
                                     (int32_t)lround(what->value * 1e4));
    case sim_inject_spindle_override:
        return cam_machine_set_param(m, cam_param_spindle_override_ppm,
                                     (int32_t)lround(what->value * 1e4));
    case sim_inject_trim:
        return cam_machine_set_param(m, cam_param_x_trim_nm, (int32_t)lround(what->value * 1e3));
    default:
        return cam_err_command;
    }
}

/// Apply an injection that is not the operator's.
static void inject(sim_cut_t *cut, const sim_inject_t *what)
{
    sim_session_t *s = &cut->session;
    if (what->kind == sim_inject_table_flip) {
        s->image[(size_t)what->value] ^= 1u;
    } else if (what->kind == sim_inject_stop) {
        operator_stop(cut);
    } else {
        sim_port_inject(&cut->port, what, s->table.direction);
    }
}

static void inject_what_is_due(sim_cut_t *cut)
{
    sim_session_t *s = &cut->session;
    sim_inject_t *what;
    while ((what = sim_session_next_inject(s, cut->port.time_s)) != NULL) {
        const cam_err_t err = operator_changes(&cut->firmware.machine, what);
        if (err == cam_err_busy) {
            what->is_done = false; // again in the next tick
            s->n_waiting++;
            return;
        }
        if (err == cam_err_command) {
            inject(cut, what);
        } else {
            take_answer(cut, err);
        }
    }
}

/// Move a measured Z: it stays at the first height until the cut, then follows the feed; at the
/// last height the cut is stopped.
static void move_z(sim_cut_t *cut)
{
    const cam_table_t *t = &cut->session.table;
    sim_drive_t *z = &cut->port.lathe.drive[hal_axis_z];
    const double share = cut->session.cut_turns / sim_cut_planned_turns(cut);
    const double span_nm = (double)t->z_last_nm - t->z_first_nm;
    z->pos_micro = t->z_first_nm + span_nm * sim_clamp(share, 0.0, 1.0);
    z->vel_micro_per_s = 0.0;
    if (share >= 1.0 && cut->state == cam_state_cutting) {
        operator_stop(cut);
    }
}

/// Act as an operator: enable, start, wait.
static void operate(sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    cam_machine_t *machine = &cut->firmware.machine;
    const cam_state_t state = cut->firmware.state;
    if (cut->n_polls++ % background_polls == 0u) {
        cam_machine_poll(machine);
    }
    if (state == cam_state_fault) {
        cut->end = sim_cut_status(cut).is_retracted ? sim_cut_fault : cut->end;
    } else if (state == cam_state_off) {
        take_answer(cut, cam_machine_enable(machine));
    } else if (state == cam_state_ready && !cut->is_started) {
        const cam_err_t err = cam_machine_start(machine);
        cut->is_started = err == cam_ok;
        take_answer(cut, err);
    } else if (state == cam_state_ready && (s->cut_at_s >= 0.0 || cut->is_stopped)) {
        if (sim_cut_has_next_pass(cut)) {
            sim_cut_next_pass(cut);
        } else {
            cut->end = sim_cut_done;
        }
    } else if (state == cam_state_ready && cut->is_near) {
        cut->end = sim_cut_unsteady;
    }
    cut->is_near = cut->is_started && cam_state_is_in_work(state);
    if (cut->options.max_turns > 0.0 && s->cut_turns >= cut->options.max_turns &&
        !cut->is_stopped) {
        operator_stop(cut);
    }
}

void sim_cut_idle(sim_cut_t *cut)
{
    sim_port_sense(&cut->port);
    sim_firmware_tick(&cut->firmware);
    observe(cut);
    sim_port_advance(&cut->port);
    cut->n_ticks++;
}

void sim_cut_tick(sim_cut_t *cut)
{
    sim_port_sense(&cut->port);
    sim_firmware_tick(&cut->firmware);
    observe(cut);
    inject_what_is_due(cut);
    sim_port_advance(&cut->port);
    if (cut->params.z_is_measured != 0) {
        move_z(cut);
    }
    cut->n_ticks++;
    if (--cut->until_poll == 0u) {
        cut->until_poll = sim_cut_poll_ticks;
        operate(cut);
        if (cut->end == sim_cut_running && cut->port.time_s > cut->max_s) {
            cut->end = sim_cut_timeout;
        }
    }
}

void sim_cut_close(sim_cut_t *cut)
{
    sim_session_close(&cut->session);
}
