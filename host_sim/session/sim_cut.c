// SPDX-License-Identifier: Apache-2.0
#include "sim_cut.h"
#include "sim_cam_cut.h" // sim_cam_cut_gauge
#include "sim_units.h"   // sim_fraction
#include <math.h>        // ceil, sqrt
#include <stdlib.h>      // free

/// A real main loop does its background work whenever the interrupt leaves time; here rarely, since
/// a kilobyte of CRC costs as much as 10 ticks. A damaged table of 16 KB is found within 0.8 s at
/// 20 kHz.
enum { background_polls = 64 };

const cam_status_t *sim_cut_status(const sim_cut_t *cut)
{
    return &cut->firmware.status;
}

double sim_cut_feed_mm(const sim_cut_t *cut)
{
    const double feed_nm =
        cut->params.feed_nm > 0 ? cut->params.feed_nm : (double)cut->table.feed_nm;
    return feed_nm / SIM_NM_PER_MM;
}

bool sim_cut_has_rings(const sim_cut_t *cut)
{
    return cut->table.is_ring_helix && cut->params.z_is_measured == 0;
}

double sim_cut_planned_turns(const sim_cut_t *cut)
{
    const double span_nm = (double)cut->table.z_last_nm - cut->table.z_first_nm;
    const double fed = span_nm / (sim_cut_feed_mm(cut) * SIM_NM_PER_MM);
    if (sim_cut_has_rings(cut)) {
        return 2.0 * ceil(fed) + 1.0;
    }
    const double ramp = cut->params.z_is_measured != 0 ? 0.0 : cut->params.feed_ramp_turns;
    return fed + (ramp < fed ? ramp : fed); // the rising and the falling half
}

uint32_t sim_cut_lobe_without_turn(const sim_cut_t *cut)
{
    uint32_t i = 0;
    while (i < cut->design.cam.n_lobes && cut->cam.gauge[i].n >= sim_cam_dexels) {
        i++;
    }
    return i;
}

bool sim_cut_is_gauged(const sim_cut_t *cut)
{
    // A Z that others lead ends with a stop, too.
    const bool is_whole = !cut->is_stopped || cut->cut_turns >= sim_cut_planned_turns(cut);
    const bool has_lobes = cut->design.shape == sim_shape_cam && is_whole;
    return cut->work.n > 0u &&
           (!has_lobes || sim_cut_lobe_without_turn(cut) == cut->design.cam.n_lobes);
}

double sim_cut_following_rms_um(const sim_cut_t *cut)
{
    return cut->n_following > 0u ? sqrt(cut->following_sum_um2 / (double)cut->n_following) : 0.0;
}

/// The tool tip against the exact surface at its true place.
static void gauge(sim_cut_t *cut)
{
    const sim_machine_t *m = &cut->machine;
    const double turn = cut->table.direction > 0 ? m->spindle.turn : -m->spindle.turn;
    cut->sample_s = m->time_s;
    cut->true_turn = m->spindle.turn;
    cut->part_turn = sim_fraction(turn - cut->phase_turn);
    cut->z_mm = sim_machine_z_mm(m);
    cut->swing_deg = sim_machine_swing_deg(m);
    if (cut->design.shape == sim_shape_cam) {
        sim_cam_cut_gauge(cut, turn - cut->phase_turn);
        return;
    }
    cut->radius_mm = sim_machine_radius_mm(m);
    cut->exact_mm = sim_design_radius_mm(&cut->design, cut->part_turn, cut->z_mm);
    sim_work_touch(&cut->work, cut->part_turn, cut->z_mm, cut->radius_mm, cut->exact_mm,
                   cut->state == cam_state_cutting);
    sim_scallop_touch(&cut->scallop, &cut->design, cut->part_turn, cut->z_mm, cut->radius_mm,
                      cut->exact_mm);
}

static void count_cutting(sim_cut_t *cut, const cam_status_t *status)
{
    if (cut->cut_at_s < 0.0) {
        cut->cut_at_s = cut->machine.time_s;
        cut->cut_at_turn = cut->machine.spindle.turn;
    }
    cut->cut_s = cut->machine.time_s - cut->cut_at_s;
    cut->cut_turns = sim_abs(cut->machine.spindle.turn - cut->cut_at_turn);
    const double off_um = sim_abs(status->following_nm * 1e-3);
    cut->following_max_um = off_um > cut->following_max_um ? off_um : cut->following_max_um;
    cut->following_sum_um2 += off_um * off_um;
    cut->n_following++;
}

/// While cutting; turns in which the feed eases are not judged, those of a ring-helix neither.
static void measure_removal(sim_cut_t *cut)
{
    const double turn = cut->table.direction > 0 ? cut->true_turn : -cut->true_turn;
    const double ramp = cut->params.feed_ramp_turns;
    const bool is_full = !sim_cut_has_rings(cut) && cut->cut_turns > ramp &&
                         cut->cut_turns < sim_cut_planned_turns(cut) - ramp;
    cut->has_slice = sim_removal_touch(&cut->removal, cut->sample_s, turn - cut->phase_turn,
                                       cut->z_mm, cut->radius_mm, is_full && !cut->is_stopped);
}

static void note_fault(sim_cut_t *cut)
{
    cut->fault_s = cut->machine.time_s;
    cut->fault_turn = cut->part_turn;
    cut->fault_z_mm = cut->z_mm;
    cut->fault_state = cut->state; // of the tick before
}

static void observe(sim_cut_t *cut)
{
    const cam_status_t *status = sim_cut_status(cut);
    if (status->state == cam_state_fault && cut->fault_s < 0.0) {
        note_fault(cut);
    }
    cut->state = status->state;
    cut->has_slice = false;
    gauge(cut);
    if (status->state == cam_state_cutting) {
        count_cutting(cut, status);
    }
    if (status->state == cam_state_cutting && cut->design.shape != sim_shape_cam) {
        measure_removal(cut);
    }
}

static void operator_stop(sim_cut_t *cut)
{
    cut->is_stopped = sim_firmware_stop(&cut->firmware) == cam_ok || cut->is_stopped;
}

static void inject(sim_cut_t *cut, sim_inject_t *what)
{
    const double zero_s = what->is_absolute ? 0.0 : cut->cut_at_s;
    if (what->is_done || zero_s < 0.0 || cut->machine.time_s < zero_s + what->at_s) {
        return;
    }
    what->is_done = true;
    cut->n_waiting--;
    if (what->kind == sim_inject_table_flip) {
        sim_firmware_flip(&cut->firmware, cut->image, (size_t)what->value);
    } else if (what->kind == sim_inject_stop) {
        operator_stop(cut);
    }
    sim_inject_apply(what, &cut->machine, cut->table.direction);
}

/// Z led by others: at the first height until the cut, then by the feed, and stop at the last
/// height.
static void lead_z(sim_cut_t *cut)
{
    sim_drive_t *z = &cut->machine.axis[hal_axis_z];
    const double share = cut->cut_turns / sim_cut_planned_turns(cut);
    const double span_nm = (double)cut->table.z_last_nm - cut->table.z_first_nm;
    z->pos_nm = cut->table.z_first_nm + span_nm * sim_clamp(share, 0.0, 1.0);
    z->vel_nm_per_s = 0.0;
    if (share >= 1.0 && cut->state == cam_state_cutting) {
        operator_stop(cut);
    }
}

static void refuse(sim_cut_t *cut, cam_err_t err)
{
    if (err != cam_ok && err != cam_err_busy) {
        cut->refusal = err;
        cut->end = sim_cut_refused;
    }
}

/// What an operator does: enable, start, wait.
static void operate(sim_cut_t *cut)
{
    const cam_status_t status = *sim_cut_status(cut);
    if (cut->n_polls++ % background_polls == 0u) {
        sim_firmware_poll(&cut->firmware);
    }
    if (status.state == cam_state_fault) {
        cut->end = status.is_retracted ? sim_cut_fault : cut->end;
    } else if (status.state == cam_state_off) {
        refuse(cut, sim_firmware_enable(&cut->firmware));
    } else if (status.state == cam_state_ready && !cut->is_started) {
        const cam_err_t err = sim_firmware_start(&cut->firmware);
        cut->is_started = err == cam_ok;
        refuse(cut, err);
    } else if (status.state == cam_state_ready && (cut->cut_at_s >= 0.0 || cut->is_stopped)) {
        cut->end = sim_cut_done;
    }
    if (cut->options.max_turns > 0.0 && cut->cut_turns >= cut->options.max_turns &&
        !cut->is_stopped) {
        operator_stop(cut);
    }
}

void sim_cut_idle(sim_cut_t *cut)
{
    sim_machine_sense(&cut->machine);
    (void)sim_firmware_tick(&cut->firmware); // a lost target refuses the next call
    observe(cut);
    sim_machine_advance(&cut->machine);
    cut->n_ticks++;
}

void sim_cut_tick(sim_cut_t *cut)
{
    sim_machine_sense(&cut->machine);
    if (!sim_firmware_tick(&cut->firmware)) {
        cut->end = sim_cut_lost;
        return;
    }
    observe(cut);
    if (cut->n_waiting > 0u) {
        for (uint32_t i = 0; i < cut->options.n_injects; i++) {
            inject(cut, &cut->options.inject[i]);
        }
    }
    sim_machine_advance(&cut->machine);
    if (cut->params.z_is_measured != 0) {
        lead_z(cut);
    }
    cut->n_ticks++;
    if (--cut->until_poll == 0u) {
        cut->until_poll = sim_cut_poll_ticks;
        operate(cut);
        if (cut->end == sim_cut_running && cut->machine.time_s > cut->max_s) {
            cut->end = sim_cut_timeout;
        }
    }
}

void sim_cut_close(sim_cut_t *cut)
{
    sim_firmware_close(&cut->firmware);
    sim_design_free(&cut->design);
    free(cut->image);
    cut->image = NULL;
}
