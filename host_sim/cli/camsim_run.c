// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): clock_gettime
#include "camsim.h"
#include "camsim_cam.h"     // camsim_cam_check
#include "camsim_out.h"     // camsim_out_t
#include "camsim_summary.h" // camsim_summary_json
#include "camsim_trace.h"   // camsim_trace_drain
#include <stdio.h>          // fprintf
#include <stdlib.h>         // calloc, free
#include <time.h>           // clock_gettime

enum { progress_ticks = 1 << 17 };

/// All of one run.
typedef struct {
    camsim_options_t options;
    sim_cut_t cut;
    camsim_out_t trace, surface, summary, removal, scallop;
    double wall_s;
} run_t;

static double now_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool open_cut(run_t *r, sim_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, r->options.table_path, camsim_max_table_bytes, e)) {
        return false;
    }
    const bool is_good =
        sim_cut_open(&r->cut, &r->options.cut, file.bytes, file.size, r->options.table_path, e);
    sim_file_free(&file);
    if (is_good && r->options.cut.design_path == NULL) {
        (void)fprintf(stderr,
                      "camsim: warning: %s: missing, so the gauge compares with the table itself\n",
                      r->options.design_path);
    }
    return is_good;
}

static bool open_outputs(run_t *r, sim_error_t *e)
{
    camsim_out_watch_signals();
    return camsim_cam_check(&r->options, &r->cut, e) &&
           camsim_out_open(&r->trace, r->options.trace_path, "--trace", e) &&
           camsim_out_open(&r->surface, r->options.surface_path, "--surface", e) &&
           camsim_out_open(&r->summary, r->options.summary_path, "--summary", e) &&
           camsim_out_open(&r->removal, r->options.removal_path, "--removal", e) &&
           camsim_out_open(&r->scallop, r->options.scallop_path, "--scallop", e);
}

static void drop_outputs(run_t *r)
{
    camsim_out_drop(&r->trace);
    camsim_out_drop(&r->surface);
    camsim_out_drop(&r->summary);
    camsim_out_drop(&r->removal);
    camsim_out_drop(&r->scallop);
}

static void show_progress(const run_t *r)
{
    const double share = r->cut.cut_turns / sim_cut_planned_turns(&r->cut);
    (void)fprintf(stderr, "\rcamsim: %5.1f %%, %.1f s of machine time", 100.0 * share,
                  r->cut.machine.time_s);
}

static void cut_to_the_end(run_t *r)
{
    sim_cut_t *cut = &r->cut;
    const double begin_s = now_s();
    while (cut->end == sim_cut_running && r->trace.error == 0 && r->removal.error == 0) {
        sim_cut_tick(cut);
        if (r->trace.name != NULL) {
            camsim_trace_drain(&r->trace, cut);
        }
        if (r->removal.name != NULL && cut->has_slice) {
            camsim_removal(&r->removal, &cut->removal.slice);
        }
        if (r->options.is_progress_shown && cut->n_ticks % progress_ticks == 0u) {
            show_progress(r);
        }
    }
    r->wall_s = now_s() - begin_s;
    if (r->options.is_progress_shown) {
        show_progress(r);
        (void)fprintf(stderr, "\n");
    }
}

static bool write_results(run_t *r, sim_error_t *e)
{
    if (r->surface.name != NULL) {
        camsim_surface(&r->surface, &r->cut.work);
    }
    if (r->scallop.name != NULL) {
        camsim_scallop(&r->scallop, &r->cut.scallop, &r->cut.design);
    }
    if (r->summary.name != NULL &&
        !camsim_summary_json(&r->summary, &r->options, &r->cut, r->wall_s)) {
        return sim_error(e, "%s: not enough memory for the summary; free some", r->summary.name);
    }
    return camsim_out_finish(&r->trace, e) && camsim_out_finish(&r->surface, e) &&
           camsim_out_finish(&r->removal, e) && camsim_out_finish(&r->scallop, e) &&
           camsim_out_finish(&r->summary, e) && camsim_out_publish(&r->trace, e) &&
           camsim_out_publish(&r->surface, e) && camsim_out_publish(&r->removal, e) &&
           camsim_out_publish(&r->scallop, e) && camsim_out_publish(&r->summary, e);
}

/// Why the first fault struck; several at once are told by the first in the list.
static void explain_fault(const sim_cut_t *cut, const char *table, sim_error_t *e)
{
    const uint32_t first = sim_cut_status(cut)->first_fault;
    int i = 0;
    while (i + 1 < cam_n_faults && (first >> i & 1u) == 0u) {
        i++;
    }
    (void)sim_error(
        e, "%s: fault %s: %s, %.6f s after the start, %s at %.3f mm; FAULTS.md tells the remedy",
        table, cam_fault_name((cam_fault_t)i), cam_fault_text((cam_fault_t)i), cut->fault_s,
        cam_state_name(cut->fault_state), cut->fault_z_mm);
}

/// A feed of half a lobe, or of half the present one, leaves a whole turn on it.
static void explain_lobe(const sim_cut_t *cut, const char *table, sim_error_t *e)
{
    const uint32_t i = sim_cut_lobe_without_turn(cut);
    const sim_cam_lobe_t *lobe = &cut->design.cam.lobe[i];
    const double high_mm = lobe->z_last_mm - lobe->z_first_mm;
    const double feed_mm = sim_cut_feed_mm(cut);
    (void)sim_error(e,
                    "%s: not gauged: lobe %u has %llu samples of the %d of a whole turn; "
                    "give at most --feed %.4g",
                    table, (unsigned)i, (unsigned long long)cut->cam.gauge[i].n, sim_cam_dexels,
                    0.5 * (high_mm < feed_mm ? high_mm : feed_mm));
}

/// Which surface the gauge has not seen.
static void explain_not_gauged(const sim_cut_t *cut, const char *table, sim_error_t *e)
{
    if (cut->work.n == 0u) {
        (void)sim_error(e,
                        "%s: not gauged: nothing was cut to full depth before the cut was %s; "
                        "leave the stop out, or stop later",
                        table, camsim_summary_end(cut));
        return;
    }
    explain_lobe(cut, table, e);
}

static int judge(const run_t *r)
{
    const sim_cut_t *cut = &r->cut;
    const char *table = r->options.table_path;
    sim_error_t e;
    if (camsim_summary_is_good(&r->options, cut)) {
        return camsim_done;
    }
    if (cut->end == sim_cut_fault) {
        explain_fault(cut, table, &e);
    } else if (cut->end == sim_cut_refused) {
        (void)sim_error(&e,
                        "%s: refused: %s; remove the cause (parameters, machine file, --inject)",
                        table, cam_err_text(cut->refusal));
        return camsim_complain(&e);
    } else if (cut->end == sim_cut_timeout) {
        (void)sim_error(&e, "%s: not at the end after %.6g s in state %s; give more --max-seconds",
                        table, cut->max_s, cam_state_name(cut->state));
    } else if (!sim_cut_is_gauged(cut)) {
        explain_not_gauged(cut, table, &e);
    } else {
        (void)sim_error(
            &e,
            "%s: form error %.3f um is beyond --tolerance-um %.6g; match the controller to "
            "the machine, or cut slower",
            table, cut->work.max_um, r->options.tolerance_um);
    }
    (void)camsim_complain(&e);
    return camsim_not_good;
}

static int run(run_t *r, sim_error_t *e)
{
    cut_to_the_end(r);
    if (sim_firmware_is_lost(&r->cut.firmware, e) || !write_results(r, e)) {
        return camsim_complain(e);
    }
    camsim_summary_text(&r->options, &r->cut, r->wall_s);
    if (fflush(stdout) != 0) {
        (void)sim_error(e, "standard output: cannot be written; make room or give another target");
        return camsim_complain(e);
    }
    return judge(r);
}

static int prepare_and_run(run_t *r, sim_error_t *e)
{
    if (!open_cut(r, e)) {
        return camsim_complain(e);
    }
    int status = camsim_wrong;
    if (open_outputs(r, e)) {
        if (r->trace.name != NULL) {
            camsim_trace_header(&r->trace, &r->cut);
        }
        if (r->removal.name != NULL) {
            camsim_removal_header(&r->removal);
        }
        status = run(r, e);
    } else {
        (void)camsim_complain(e);
    }
    drop_outputs(r);
    sim_cut_close(&r->cut);
    return status;
}

int camsim_run(int argc, char **argv)
{
    sim_error_t e;
    run_t *r = calloc(1, sizeof *r);
    if (r == NULL) {
        (void)sim_error(&e, "run: not enough memory; free 10 MB");
        return camsim_complain(&e);
    }
    int status = camsim_done;
    if (!camsim_options_read(&r->options, argc, argv, &e)) {
        status = camsim_complain(&e);
    } else if (r->options.is_help) {
        camsim_options_help();
    } else {
        status = prepare_and_run(r, &e);
    }
    free(r);
    return status;
}
