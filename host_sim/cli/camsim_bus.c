// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include "camsim_trace.h" // camsim_surface
#include "sim_units.h"    // sim_fraction
#include <stdio.h>        // fprintf
#include <stdlib.h>       // aligned_alloc, calloc, free
#include <string.h>       // memcpy

/// How long the end must last: a controller that only restarts goes on within this.
#define QUIET_S 0.25

/// No SYNC for so long: the controller has gone.
#define LOST_S 0.1

// Opening

static bool open_table(camsim_bus_t *b, sim_error_t *e)
{
    sim_file_t file;
    const char *path = b->options.common.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, e)) {
        return false;
    }
    b->image = aligned_alloc(32, (file.size + 31u) / 32u * 32u + 32u);
    if (b->image != NULL) {
        memcpy(b->image, file.bytes, file.size);
    }
    const size_t size = file.size;
    sim_file_free(&file);
    if (b->image == NULL) {
        return sim_error(e, "%s: not enough memory; use a smaller table", path);
    }
    const cam_err_t err = cam_table_check(b->image, size, &b->table);
    return err == cam_ok || sim_error(e, "%s: table refused: %s; make it again with tools/mktables",
                                      path, cam_err_text(err));
}

static bool open_design(camsim_bus_t *b, sim_error_t *e)
{
    const char *path = b->options.common.cut.design_path;
    if (b->table.angle.knots != NULL) {
        return sim_error(
            e, "%s: is the table of a cam, for which the bus has no gauge; use camsim run",
            b->options.common.table_path);
    }
    if (path != NULL) {
        return sim_design_load(&b->design, path, &b->table, e);
    }
    (void)fprintf(stderr,
                  "camsim: warning: %s: missing, so the gauge compares with the table itself\n",
                  b->options.common.design_path);
    sim_design_from_table(&b->design, &b->table);
    return true;
}

/// As camsim run places it.
static void place_machine(camsim_bus_t *b)
{
    const camsim_bus_options_t *o = &b->options;
    sim_bus_config_t config = {
        .machine = o->common.cut.config.machine,
        .guard_s = o->guard_ms * 1e-3,
        .heartbeat_s = o->heartbeat_ms * 1e-3,
        .encoder_modulus = (uint32_t)o->encoder_modulus,
        .seed = o->common.cut.seed,
    };
    config.machine.tick_hz = o->tick_hz;
    memcpy(config.is_foreign, o->is_foreign, sizeof config.is_foreign);
    const double blank_mm = b->design.largest_mm + b->table.depth_nm / SIM_NM_PER_MM;
    const double x_nm = (blank_mm + config.machine.x_start_mm) * SIM_NM_PER_MM;
    const double z_nm = b->table.z_first_nm - config.machine.z_start_mm * SIM_NM_PER_MM;
    sim_work_init(&b->work, blank_mm, b->design.z_first_mm, b->design.z_last_mm);
    sim_bus_init(&b->bus, &config, x_nm, z_nm);
    b->cut_at_s = -1.0;
    b->quiet_s = -1.0;
    b->fault_s = -1.0;
    b->stopped_s = -1.0;
}

static bool open_outputs(camsim_bus_t *b, sim_error_t *e)
{
    const camsim_options_t *o = &b->options.common;
    if (!camsim_out_open(&b->trace, o->trace_path, "--trace", e) ||
        !camsim_out_open(&b->surface, o->surface_path, "--surface", e) ||
        !camsim_out_open(&b->summary, o->summary_path, "--summary", e)) {
        return false;
    }
    if (b->trace.name != NULL) {
        camsim_bus_trace_header(&b->trace);
    }
    return true;
}

// One period

/// Without lines what the controller says of itself counts.
static sim_bus_outputs_t outputs_of(const camsim_bus_t *b)
{
    const sim_bus_t *bus = &b->bus;
    if (b->link.has_lines) {
        return camsim_link_read(&b->link);
    }
    return (sim_bus_outputs_t){
        .is_enabled = sim_cia402_is_following(&bus->node[sim_bus_u].power),
        .is_fault = bus->told_faults != 0u,
        .is_in_cut = bus->has_status && bus->told_state == cam_state_cutting,
    };
}

static void count_cutting(camsim_bus_t *b)
{
    const sim_bus_sample_t *s = &b->bus.sample;
    const double off_um = sim_abs(s->u_nm - (double)b->bus.node[sim_bus_u].active.target) * 1e-3;
    if (b->cut_at_s < 0.0) {
        b->cut_at_s = s->t_s;
        b->cut_at_turn = s->turn;
    }
    b->cut_s = s->t_s - b->cut_at_s;
    b->cut_turns = sim_abs(s->turn - b->cut_at_turn);
    b->following_max_um = off_um > b->following_max_um ? off_um : b->following_max_um;
    b->following_sum_um2 += off_um * off_um;
}

static void gauge(camsim_bus_t *b)
{
    const sim_bus_sample_t *s = &b->bus.sample;
    b->part_turn = sim_fraction(s->turn * b->table.direction);
    b->z_mm = s->z_nm * 1e-6;
    b->radius_mm = (s->x_nm - s->u_nm) * 1e-6;
    b->exact_mm = sim_design_radius_mm(&b->design, b->part_turn, b->z_mm);
    sim_work_touch(&b->work, b->part_turn, b->z_mm, b->radius_mm, b->exact_mm,
                   b->outputs.is_in_cut);
    if (b->outputs.is_in_cut) {
        count_cutting(b);
    }
}

static void inject(camsim_bus_t *b)
{
    sim_cut_options_t *o = &b->options.common.cut;
    for (uint32_t i = 0; i < o->n_injects; i++) {
        sim_inject_t *what = &o->inject[i];
        const double zero_s = what->is_absolute ? 0.0 : b->cut_at_s;
        if (!what->is_done && zero_s >= 0.0 && b->bus.time_s >= zero_s + what->at_s) {
            what->is_done = true;
            sim_bus_inject(&b->bus, what, b->table.direction);
        }
    }
}

// The end

static bool is_gone(const camsim_bus_t *b)
{
    return b->bus.n_syncs > 0u && b->bus.time_s - b->bus.sync_s > LOST_S;
}

static bool is_cut(const camsim_bus_t *b)
{
    const sim_bus_t *bus = &b->bus;
    return b->cut_at_s >= 0.0 && !b->outputs.is_in_cut &&
           (!bus->has_status || bus->told_state == cam_state_ready);
}

/// What the end would be if nothing more happened.
static camsim_bus_end_t end_in_sight(const camsim_bus_t *b)
{
    const bool is_at_rest = sim_bus_is_at_rest(&b->bus);
    if (is_gone(b)) {
        return is_at_rest ? camsim_bus_lost : camsim_bus_running;
    }
    if (b->outputs.is_fault) {
        return is_at_rest && !b->outputs.is_enabled ? camsim_bus_fault : camsim_bus_running;
    }
    return is_cut(b) ? camsim_bus_done : camsim_bus_running;
}

static void note_faults(camsim_bus_t *b)
{
    b->faults |= b->bus.told_faults;
    if (b->outputs.is_fault && b->fault_s < 0.0) {
        b->fault_s = b->bus.sample.t_s;
    }
    const bool is_over = is_gone(b) || b->outputs.is_fault;
    if (is_over && sim_bus_is_at_rest(&b->bus)) {
        b->stopped_s = b->stopped_s < 0.0 ? b->bus.time_s : b->stopped_s;
    } else {
        b->stopped_s = -1.0;
    }
}

static void look_for_end(camsim_bus_t *b)
{
    const camsim_bus_end_t end = end_in_sight(b);
    if (end != b->quiet_end || b->quiet_s < 0.0) {
        b->quiet_end = end;
        b->quiet_s = b->bus.time_s;
    }
    if (!b->options.is_staying && b->bus.time_s - b->quiet_s >= QUIET_S) {
        b->end = end;
    }
    if (b->bus.time_s > b->options.common.cut.max_s) {
        b->end = camsim_bus_timeout;
    }
    if (camsim_link_is_stopped()) {
        b->end = camsim_bus_stopped;
    }
}

static void live(camsim_bus_t *b)
{
    while (b->end == camsim_bus_running && b->trace.error == 0) {
        camsim_link_wait(&b->link, &b->bus);
        b->outputs = outputs_of(b);
        inject(b);
        sim_bus_step(&b->bus);
        camsim_link_speak(&b->link, &b->bus);
        gauge(b);
        note_faults(b);
        if (b->trace.name != NULL) {
            camsim_bus_trace_line(b);
        }
        look_for_end(b);
    }
}

// Results

static bool write_results(camsim_bus_t *b, sim_error_t *e)
{
    if (b->surface.name != NULL) {
        camsim_surface(&b->surface, &b->work);
    }
    if (b->summary.name != NULL && !camsim_bus_summary(b)) {
        return sim_error(e, "%s: not enough memory for the summary; free some", b->summary.name);
    }
    return camsim_out_finish(&b->trace, e) && camsim_out_finish(&b->surface, e) &&
           camsim_out_finish(&b->summary, e) && camsim_out_publish(&b->trace, e) &&
           camsim_out_publish(&b->surface, e) && camsim_out_publish(&b->summary, e);
}

static void print_summary(const camsim_bus_t *b)
{
    (void)printf("%s on machine %s: %.1f turns cut, %s\n", b->table.name,
                 b->options.common.cut.config.name, b->cut_turns, camsim_bus_end_name(b->end));
    if (b->work.n > 0u) {
        (void)printf("form error      max %.4f um, rms %.4f um (tolerance %.6g um)\n",
                     b->work.max_um, sim_work_rms_um(&b->work), b->options.common.tolerance_um);
    }
    (void)printf("machine time    %.3f s, %llu ticks heard\n", b->bus.time_s,
                 (unsigned long long)b->bus.n_syncs);
}

static int judge(const camsim_bus_t *b)
{
    sim_error_t e;
    if (b->end == camsim_bus_stopped ||
        (b->end == camsim_bus_done && b->work.max_um <= b->options.common.tolerance_um)) {
        return camsim_done;
    }
    if (b->end == camsim_bus_done) {
        (void)sim_error(&e,
                        "%s: form error %.3f um is beyond --tolerance-um %.6g; match the "
                        "controller to the machine",
                        b->options.common.table_path, b->work.max_um,
                        b->options.common.tolerance_um);
    } else {
        (void)sim_error(&e, "%s: no whole cut: %s at %.3f s; the trace tells more",
                        b->options.common.table_path, camsim_bus_end_name(b->end), b->bus.time_s);
    }
    (void)camsim_complain(&e);
    return camsim_not_good;
}

static int live_and_judge(camsim_bus_t *b, sim_error_t *e)
{
    camsim_link_watch_signals();
    live(b);
    if (!write_results(b, e)) {
        return camsim_complain(e);
    }
    print_summary(b);
    return fflush(stdout) == 0 ? judge(b) : camsim_wrong;
}

static int prepare_and_live(camsim_bus_t *b, sim_error_t *e)
{
    int status = camsim_wrong;
    if (!open_table(b, e) || !open_design(b, e)) {
        return camsim_complain(e);
    }
    place_machine(b);
    if (!camsim_link_open(&b->link, b->options.interface, b->options.chip, b->bus.period_s, e)) {
        return camsim_complain(e);
    }
    if (open_outputs(b, e)) {
        status = live_and_judge(b, e);
    } else {
        (void)camsim_complain(e);
    }
    camsim_out_drop(&b->trace);
    camsim_out_drop(&b->surface);
    camsim_out_drop(&b->summary);
    camsim_link_close(&b->link);
    return status;
}

int camsim_bus(int argc, char **argv)
{
    sim_error_t e;
    camsim_bus_t *b = calloc(1, sizeof *b);
    if (b == NULL) {
        (void)sim_error(&e, "bus: not enough memory; free 10 MB");
        return camsim_complain(&e);
    }
    int status = camsim_done;
    if (!camsim_bus_options_read(&b->options, argc, argv, &e)) {
        status = camsim_complain(&e);
    } else if (b->options.common.is_help) {
        camsim_bus_options_help();
    } else {
        status = prepare_and_live(b, &e);
        sim_design_free(&b->design);
        free(b->image);
    }
    free(b);
    return status;
}
