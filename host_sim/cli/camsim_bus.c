// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include "sim_map.h"       // sim_map_surface
#include "sim_watch_out.h" // sim_watch_summary
#include <stdio.h>         // printf

/// Trace, surface and summary.
enum { n_outs = camsim_summary + 1 };

typedef struct {
    camsim_bus_options_t options;
    sim_watch_t watch;
    sim_out_t out[n_outs];
} bus_t;

static void watch_to_the_end(bus_t *b)
{
    sim_out_t *trace = &b->out[camsim_trace];
    sim_link_watch_signals();
    if (trace->name != NULL) {
        sim_watch_trace_header(trace);
    }
    while (b->watch.end == sim_watch_running && trace->error == 0) {
        sim_watch_tick(&b->watch);
        if (trace->name != NULL) {
            sim_watch_trace_line(trace, &b->watch);
        }
    }
}

static void print_summary(const sim_watch_t *w)
{
    const sim_session_t *s = &w->session;
    (void)printf("%s on machine %s: %.1f turns cut, %s\n", s->table.name, s->options.config.name,
                 s->cut_turns, sim_watch_end_name(w));
    if (s->work.n > 0u) {
        (void)printf("form error      max %.4f um, rms %.4f um (tolerance %.6g um)\n",
                     s->work.max_um, sim_work_rms_um(&s->work), s->options.tolerance_um);
    }
    (void)printf("machine time    %.3f s, %llu ticks heard\n", w->bus.time_s,
                 (unsigned long long)w->bus.n_syncs);
}

static int judge(const sim_watch_t *w, const char *table)
{
    const sim_session_t *s = &w->session;
    common_error_t e;
    if (sim_watch_is_good(w)) {
        return camsim_done;
    }
    if (w->end == sim_watch_done) {
        (void)common_error(&e,
                           "%s: form error %.3f um is beyond --tolerance-um %.6g; match the "
                           "controller to the machine",
                           table, s->work.max_um, s->options.tolerance_um);
    } else {
        (void)common_error(&e, "%s: cut not completed: %s at %.3f s; see the trace", table,
                           sim_watch_end_name(w), w->bus.time_s);
    }
    (void)camsim_complain(&e);
    return camsim_not_good;
}

/// The whole cut on the bus. @return exit status
static int watch(bus_t *b, common_error_t *e)
{
    const camsim_options_t *o = &b->options.common;
    if (!sim_watch_connect(&b->watch, e) || !camsim_open_outs(b->out, o, n_outs, e)) {
        return camsim_complain(e);
    }
    watch_to_the_end(b);
    sim_out_t *summary = &b->out[camsim_summary];
    if (b->out[camsim_surface].name != NULL) {
        sim_map_surface(&b->out[camsim_surface], &b->watch.session);
    }
    if (summary->name != NULL && !sim_watch_summary(summary, &b->watch)) {
        (void)common_error(e, "%s: not enough memory for the summary; free some", summary->name);
        return camsim_complain(e);
    }
    if (!sim_out_publish_all(b->out, n_outs, e)) {
        return camsim_complain(e);
    }
    print_summary(&b->watch);
    return fflush(stdout) == 0 ? judge(&b->watch, o->table_path) : camsim_wrong;
}

int camsim_bus(int argc, char **argv)
{
    static bus_t b; // 10 MB
    common_error_t e;
    if (!camsim_bus_options_read(&b.options, argc, argv, &e)) {
        return camsim_complain(&e);
    }
    if (b.options.common.is_help) {
        camsim_bus_options_help();
        return camsim_done;
    }
    camsim_warn_of_retired(&b.options.common);
    sim_file_t file;
    const char *path = b.options.common.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, &e)) {
        return camsim_complain(&e);
    }
    const bool is_open =
        sim_watch_open(&b.watch, &b.options.watch, file.bytes, file.size, path, &e);
    sim_file_free(&file);
    if (!is_open) {
        return camsim_complain(&e);
    }
    camsim_warn_of_design(&b.options.common);
    const int status = watch(&b, &e);
    sim_out_drop_all(b.out, n_outs);
    sim_watch_close(&b.watch);
    return status;
}
