// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include "sim_watch_out.h" // sim_watch_summary
#include <stdio.h>         // printf

typedef struct {
    camsim_bus_options_t options;
    sim_watch_t watch;
    sim_rows_t trace, surface;
    sim_out_t out[camsim_n_outs];
} bus_t;

static void watch_to_the_end(bus_t *b)
{
    sim_out_t *trace = &b->out[sim_table_trace];
    sim_link_watch_signals();
    sim_rows_open(&b->trace, sim_watch_trace_columns);
    if (trace->name != NULL) {
        sim_out_header(trace, &b->trace);
    }
    while (b->watch.end == sim_watch_running && trace->error == 0) {
        sim_watch_tick(&b->watch);
        if (trace->name != NULL) {
            sim_watch_trace_row(&b->trace, &b->watch);
            sim_out_rows(trace, &b->trace);
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
        camsim_print_zones(s);
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
        camsim_explain_form(s, table, "match the controller to the machine", &e);
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
    if (!sim_watch_connect(&b->watch, e) ||
        !sim_out_open_all(b->out, o->out_path, camsim_out_option, camsim_n_outs, e)) {
        return camsim_complain(e);
    }
    watch_to_the_end(b);
    sim_out_t *surface = &b->out[sim_table_surface];
    if (surface->name != NULL) {
        sim_tables_surface(&b->surface, &b->watch.session);
        sim_out_header(surface, &b->surface);
        sim_out_rows(surface, &b->surface);
    }
    if (!camsim_publish(b->out, sim_watch_summary(&b->watch), e)) {
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
    sim_out_drop_all(b.out, camsim_n_outs);
    sim_rows_free(&b.trace);
    sim_rows_free(&b.surface);
    sim_watch_close(&b.watch);
    return status;
}
