// SPDX-License-Identifier: Apache-2.0
#include "sim_watch_out.h"
#include "hal/version.h" // CAMTURN_VERSION
#include "sim_summary.h" // sim_summary_number
#include "sim_units.h"   // SIM_NM_PER_MM, sim_round

static const char trace_header[] =
    "tick,t_s,turn,z_mm,u_set_nm,u_act_nm,state,faults,true_turn,true_z_mm,radius_mm,error_nm,"
    "enable,fault,in_cut,syncs,encoder_counts,"
    "u_control,u_status,u_target,u_actual,u_offset,x_control,x_status,x_target,x_actual,x_offset,"
    "z_control,z_status,z_target,z_actual,z_offset,"
    "spindle_control,spindle_status,spindle_target,spindle_actual\n";

void sim_watch_trace_header(sim_out_t *o)
{
    sim_out_text(o, trace_header);
}

static void drive_columns(sim_out_t *o, const sim_node_t *node, double actual)
{
    sim_out_hex_column(o, node->active.control_word, 4);
    sim_out_hex_column(o, sim_cia402_status(&node->power), 4);
    sim_out_integer_column(o, node->active.target);
    sim_out_integer_column(o, (int64_t)sim_round(actual));
}

void sim_watch_trace_line(sim_out_t *o, const sim_watch_t *w)
{
    const sim_session_t *s = &w->session;
    const sim_bus_t *bus = &w->bus;
    const double actual[] = {s->at.u_nm, s->at.x_nm, s->at.z_nm};
    sim_out_integer(o, (int64_t)bus->n_steps);
    sim_out_real_column(o, s->at.t_s, 9);
    sim_out_real_column(o, s->at.turn, 9);
    sim_out_real_column(o, s->z_mm, 6);
    sim_out_integer_column(o, bus->node[sim_bus_u].active.target);
    sim_out_integer_column(o, (int64_t)sim_round(s->at.u_nm));
    sim_out_word_column(o, sim_watch_state(w), 0);
    sim_out_hex_column(o, bus->reported_faults, 8);
    sim_out_real_column(o, s->at.turn, 9);
    sim_out_real_column(o, s->z_mm, 9);
    sim_out_real_column(o, s->radius_mm, 9);
    sim_out_real_column(o, (s->radius_mm - s->exact_mm) * SIM_NM_PER_MM, 3);
    sim_out_integer_column(o, w->outputs.is_enabled ? 1 : 0);
    sim_out_integer_column(o, w->outputs.is_fault ? 1 : 0);
    sim_out_integer_column(o, w->outputs.is_in_cut ? 1 : 0);
    sim_out_integer_column(o, (int64_t)bus->n_syncs);
    sim_out_integer_column(o, bus->encoder_counts);
    for (int i = 0; i < hal_n_axes; i++) {
        drive_columns(o, &bus->node[sim_bus_u + i], actual[i]);
        sim_out_integer_column(o, bus->node[sim_bus_u + i].active.velocity_offset);
    }
    drive_columns(o, &bus->node[sim_bus_spindle],
                  sim_spindle_true_rad_per_s(&bus->lathe.spindle) * (60000.0 / SIM_TWO_PI));
    sim_out_char(o, '\n');
}

bool sim_watch_summary(sim_out_t *o, const sim_watch_t *w)
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
    sim_summary_metal(cut, s);
    cJSON *drives = cJSON_AddObjectToObject(root, "status_words");
    for (int i = sim_bus_u; i < sim_bus_n_nodes; i++) {
        sim_summary_number(drives, name[i], sim_cia402_status(&w->bus.node[i].power));
    }
    sim_summary_number(root, "machine_time_s", w->bus.time_s);
    sim_summary_number(root, "ticks", (double)w->bus.n_steps);
    sim_summary_number(root, "syncs", (double)w->bus.n_syncs);
    sim_summary_number(root, "tick_hz", w->options.tick_hz);
    sim_summary_number(root, "unsent_frames", (double)w->link.n_unsent);
    return sim_summary_write(o, root);
}
