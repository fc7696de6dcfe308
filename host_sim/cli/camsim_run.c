// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): clock_gettime
#include "camsim.h"
#include "sim_cut_summary.h" // sim_cut_summary
#include "sim_cut_pass.h"    // sim_cut_planned_s
#include "sim_map.h"         // sim_map_surface
#include "sim_trace.h"       // sim_trace_drain
#include <stdio.h>           // fprintf
#include <time.h>            // clock_gettime
#include <unistd.h>          // isatty

enum { progress_ticks = 1 << 16 };

/// All of one run.
typedef struct {
    camsim_options_t options;
    sim_cut_t cut;
    sim_out_t out[camsim_n_outs];
    double wall_s;
    double begin_s, shown_s; ///< [s] clock times of the start and of the last progress
} run_t;

/// Period of progress lines when not on a terminal.
#define LINE_EVERY_S 20.0

static double now_s(void)
{
    struct timespec t;
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool open_outputs(run_t *r, common_error_t *e)
{
    sim_out_watch_signals();
    if (!camsim_check_lobes(&r->options, &r->cut, e) ||
        !camsim_open_outs(r->out, &r->options, camsim_n_outs, e)) {
        return false;
    }
    if (r->out[camsim_trace].name != NULL) {
        sim_trace_header(&r->out[camsim_trace], &r->cut);
    }
    if (r->out[camsim_removal].name != NULL) {
        sim_map_removal_header(&r->out[camsim_removal]);
    }
    return true;
}

/// Show progress and remaining time: in place on a terminal, otherwise in occasional lines.
static void show_progress(run_t *r, bool is_last)
{
    const bool is_terminal = isatty(STDERR_FILENO) != 0;
    const double gone_s = now_s() - r->begin_s;
    if (!is_last && gone_s < r->shown_s + (is_terminal ? 0.2 : LINE_EVERY_S)) {
        return;
    }
    const double share = r->cut.port.time_s / sim_cut_planned_s(&r->cut);
    const double shown = is_last || share > 1.0 ? 1.0 : share;
    r->shown_s = gone_s;
    (void)fprintf(stderr, "%scamsim: %5.1f %%, %.1f s of machine time, about %.0f s left%s",
                  is_terminal ? "\r" : "", 100.0 * shown, r->cut.port.time_s,
                  shown > 0.0 ? gone_s * (1.0 - shown) / shown : 0.0,
                  is_terminal && !is_last ? "   " : "\n");
}

static void cut_to_the_end(run_t *r)
{
    sim_cut_t *cut = &r->cut;
    sim_out_t *trace = &r->out[camsim_trace];
    sim_out_t *removal = &r->out[camsim_removal];
    r->begin_s = now_s();
    while (cut->end == sim_cut_running && trace->error == 0 && removal->error == 0) {
        sim_cut_tick(cut);
        if (trace->name != NULL) {
            sim_trace_drain(trace, cut);
        }
        if (removal->name != NULL && cut->has_slice) {
            sim_map_removal(removal, &cut->removal.slice);
        }
        if (r->options.is_progress_shown && cut->n_ticks % progress_ticks == 0u) {
            show_progress(r, false);
        }
    }
    r->wall_s = now_s() - r->begin_s;
    if (r->options.is_progress_shown) {
        show_progress(r, true);
    }
}

static bool write_results(run_t *r, common_error_t *e)
{
    sim_session_t *s = &r->cut.session;
    sim_out_t *summary = &r->out[camsim_summary];
    if (r->out[camsim_surface].name != NULL) {
        sim_map_surface(&r->out[camsim_surface], s);
    }
    if (r->out[camsim_scallop].name != NULL) {
        sim_map_scallop(&r->out[camsim_scallop], &s->scallop, sim_session_played(s));
    }
    if (r->out[camsim_sections].name != NULL) {
        sim_map_sections(&r->out[camsim_sections], s);
    }
    if (summary->name != NULL &&
        !sim_cut_summary(summary, &r->cut, r->options.table_path, r->wall_s)) {
        return common_error(e, "%s: not enough memory for the summary; free some", summary->name);
    }
    return sim_out_publish_all(r->out, camsim_n_outs, e);
}

static int run(run_t *r, common_error_t *e)
{
    cut_to_the_end(r);
    if (!write_results(r, e)) {
        return camsim_complain(e);
    }
    camsim_print_cut(&r->cut, r->wall_s);
    if (fflush(stdout) != 0) {
        (void)common_error(e,
                           "standard output: cannot be written; make room or give another target");
        return camsim_complain(e);
    }
    const int status = camsim_judge_cut(&r->cut, r->options.table_path, e);
    if (status != camsim_done) {
        (void)camsim_complain(e);
    }
    return status;
}

int camsim_run(int argc, char **argv)
{
    static run_t r; // 10 MB
    common_error_t e;
    if (!camsim_options_read(&r.options, argc, argv, &e)) {
        return camsim_complain(&e);
    }
    if (r.options.is_help) {
        camsim_options_help();
        return camsim_done;
    }
    camsim_warn_of_retired(&r.options);
    sim_file_t file;
    const char *path = r.options.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, &e)) {
        return camsim_complain(&e);
    }
    const bool is_open = sim_cut_open(&r.cut, &r.options.cut, file.bytes, file.size, path, &e);
    sim_file_free(&file);
    if (!is_open) {
        return camsim_complain(&e);
    }
    camsim_warn_of_design(&r.options);
    const int status = open_outputs(&r, &e) ? run(&r, &e) : camsim_complain(&e);
    sim_out_drop_all(r.out, camsim_n_outs);
    sim_cut_close(&r.cut);
    return status;
}
