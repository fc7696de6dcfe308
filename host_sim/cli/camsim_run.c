// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): clock_gettime
#include "camsim.h"
#include "sim_cut_summary.h" // sim_cut_summary
#include "sim_cut_pass.h"    // sim_cut_planned_s
#include <stdio.h>           // fprintf
#include <stdlib.h>          // free
#include <time.h>            // clock_gettime
#include <unistd.h>          // isatty

enum { progress_ticks = 1 << 16, batch_ticks = 64 };

/// All of one run.
typedef struct {
    camsim_options_t options;
    sim_cut_t cut;
    sim_tables_t tables;
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
        !sim_out_open_all(r->out, r->options.out_path, camsim_out_option, camsim_n_outs, e)) {
        return false;
    }
    sim_tables_open(&r->tables, &r->cut, r->options.out_path);
    for (int i = 0; i < sim_n_tables; i++) {
        if (r->tables.rows[i].columns != NULL) {
            sim_out_header(&r->out[i], &r->tables.rows[i]);
        }
    }
    return true;
}

/// Write the rows that there are. @return false when one cannot be written
static bool write_rows(run_t *r)
{
    bool is_good = true;
    for (int i = 0; i < sim_n_tables; i++) {
        sim_out_rows(&r->out[i], &r->tables.rows[i]);
        is_good = is_good && r->out[i].error == 0;
    }
    return is_good;
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
    r->begin_s = now_s();
    while (cut->end == sim_cut_running && (cut->n_ticks % batch_ticks != 0u || write_rows(r))) {
        sim_cut_tick(cut);
        sim_tables_tick(&r->tables, cut);
        if (r->options.is_progress_shown && cut->n_ticks % progress_ticks == 0u) {
            show_progress(r, false);
        }
    }
    r->wall_s = now_s() - r->begin_s;
    if (r->options.is_progress_shown) {
        show_progress(r, true);
    }
}

static int run(run_t *r, common_error_t *e)
{
    cut_to_the_end(r);
    sim_tables_end(&r->tables, &r->cut);
    (void)write_rows(r);
    if (!camsim_publish(r->out, sim_cut_summary(&r->cut, r->options.table_path, r->wall_s), e)) {
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

bool camsim_publish(sim_out_t *outs, char *summary, common_error_t *e)
{
    sim_out_t *out = &outs[camsim_summary];
    const bool is_made = summary != NULL || out->name == NULL;
    if (summary != NULL && out->name != NULL) {
        sim_out_text(out, summary);
        sim_out_text(out, "\n");
    }
    free(summary);
    return is_made ? sim_out_publish_all(outs, camsim_n_outs, e)
                   : common_error(e, "%s: not enough memory for the summary; free some", out->name);
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
    if (!camsim_open_cut(&r.options, &r.cut, &e)) {
        return camsim_complain(&e);
    }
    camsim_warn_of_design(&r.options);
    const int status = open_outputs(&r, &e) ? run(&r, &e) : camsim_complain(&e);
    sim_out_drop_all(r.out, camsim_n_outs);
    sim_tables_free(&r.tables);
    sim_cut_close(&r.cut);
    return status;
}
