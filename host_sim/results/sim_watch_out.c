// SPDX-License-Identifier: Apache-2.0
#include "sim_watch_out.h"
#include "hal/version.h" // CAMTURN_VERSION
#include "sim_summary.h" // sim_summary_number
#include "sim_units.h"   // SIM_NM_PER_MM, sim_round

const char sim_watch_trace_columns[] =
    "tick:0,t_s:9,turn:9,z_mm:6,u_set_nm:0,u_act_nm:0,state:s,faults:x8,"
    "true_turn:9,true_z_mm:9,radius_mm:9,error_nm:3,"
    "enable:0,fault:0,in_cut:0,syncs:0,encoder_counts:0,"
    "u_control:x4,u_status:x4,u_target:0,u_actual:0,u_offset:0,"
    "x_control:x4,x_status:x4,x_target:0,x_actual:0,x_offset:0,"
    "z_control:x4,z_status:x4,z_target:0,z_actual:0,z_offset:0,"
    "spindle_control:x4,spindle_status:x4,spindle_target:0,spindle_actual:0";

static void add_drive(sim_rows_t *t, const sim_node_t *node, double actual)
{
    sim_rows_add(t, node->active.control_word);
    sim_rows_add(t, sim_cia402_status(&node->power));
    sim_rows_add(t, node->active.target);
    sim_rows_add(t, (int64_t)sim_round(actual));
}

void sim_watch_trace_row(sim_rows_t *t, const sim_watch_t *w)
{
    const sim_session_t *s = &w->session;
    const sim_bus_t *bus = &w->bus;
    const double actual[] = {s->at.u_nm, s->at.x_nm, s->at.z_nm};
    sim_rows_add(t, (int64_t)bus->n_steps);
    sim_rows_real(t, s->at.t_s);
    sim_rows_real(t, s->at.turn);
    sim_rows_real(t, s->z_mm);
    sim_rows_add(t, bus->node[sim_bus_u].active.target);
    sim_rows_add(t, (int64_t)sim_round(s->at.u_nm));
    sim_rows_add(t, bus->has_status ? (int64_t)bus->reported_state : -1);
    sim_rows_add(t, bus->reported_faults);
    sim_rows_real(t, s->at.turn);
    sim_rows_real(t, s->z_mm);
    sim_rows_real(t, s->radius_mm);
    sim_rows_real(t, (s->radius_mm - s->exact_mm) * SIM_NM_PER_MM);
    sim_rows_add(t, w->outputs.is_enabled ? 1 : 0);
    sim_rows_add(t, w->outputs.is_fault ? 1 : 0);
    sim_rows_add(t, w->outputs.is_in_cut ? 1 : 0);
    sim_rows_add(t, (int64_t)bus->n_syncs);
    sim_rows_add(t, bus->encoder_counts);
    for (int i = 0; i < hal_n_axes; i++) {
        add_drive(t, &bus->node[sim_bus_u + i], actual[i]);
        sim_rows_add(t, bus->node[sim_bus_u + i].active.velocity_offset);
    }
    add_drive(t, &bus->node[sim_bus_spindle],
              sim_spindle_true_rad_per_s(&bus->lathe.spindle) * (60000.0 / SIM_TWO_PI));
}

char *sim_watch_summary(const sim_watch_t *w)
{
    static const char *const name[] = {"encoder", "u", "x", "z", "spindle"};
    const sim_session_t *s = &w->session;
    cJSON *root = cJSON_CreateObject();
    sim_summary_text(root, "camsim", CAMTURN_VERSION);
    sim_summary_text(root, "part", s->table.name);
    sim_summary_number(root, "table_crc32", s->table.crc32);
    sim_summary_text(root, "machine", s->options.config.name);
    sim_summary_text(root, "end", sim_watch_end_name(w));
    sim_summary_text(root, "state", sim_watch_state(w));
    sim_summary_faults(root, "faults", w->faults);
    if (w->fault_s >= 0.0) {
        sim_summary_number(root, "fault_s", w->fault_s);
    }
    if (w->stopped_s >= 0.0) {
        sim_summary_number(root, "at_rest_s", w->stopped_s);
    }
    sim_summary_errors(root, s);
    cJSON *cut = cJSON_AddObjectToObject(root, "cut");
    sim_summary_progress(cut, s);
    cJSON *drives = cJSON_AddObjectToObject(root, "status_words");
    for (int i = sim_bus_u; i < sim_bus_n_nodes; i++) {
        sim_summary_number(drives, name[i], sim_cia402_status(&w->bus.node[i].power));
    }
    sim_summary_number(root, "machine_time_s", w->bus.time_s);
    sim_summary_number(root, "ticks", (double)w->bus.n_steps);
    sim_summary_number(root, "syncs", (double)w->bus.n_syncs);
    sim_summary_number(root, "tick_hz", w->options.tick_hz);
    sim_summary_number(root, "unsent_frames", (double)w->link.n_unsent);
    return sim_summary_print(root);
}
