// SPDX-License-Identifier: Apache-2.0
#include "camsim_bus.h"
#include "sim_units.h" // SIM_NM_PER_MM
#include <cjson/cJSON.h>
#include <math.h> // sqrt

static const char trace_header[] =
    "tick,t_s,turn,z_mm,u_set_nm,u_act_nm,state,faults,true_turn,true_z_mm,radius_mm,error_nm,"
    "enable,fault,in_cut,syncs,encoder_counts,"
    "u_control,u_status,u_target,u_actual,u_offset,x_control,x_status,x_target,x_actual,x_offset,"
    "z_control,z_status,z_target,z_actual,z_offset,"
    "spindle_control,spindle_status,spindle_target,spindle_actual\n";

void camsim_bus_trace_header(camsim_out_t *o)
{
    camsim_out_text(o, trace_header);
}

static void integer(camsim_out_t *o, int64_t value)
{
    camsim_out_char(o, ',');
    camsim_out_integer(o, value);
}

static void real(camsim_out_t *o, double value, int decimals)
{
    camsim_out_char(o, ',');
    camsim_out_real(o, value, decimals);
}

static void word(camsim_out_t *o, uint32_t value, int n_digits)
{
    camsim_out_text(o, ",0x");
    for (int shift = 4 * (n_digits - 1); shift >= 0; shift -= 4) {
        camsim_out_char(o, "0123456789abcdef"[(value >> shift) & 15u]);
    }
}

static void drive_columns(camsim_out_t *o, const sim_node_t *node, double actual)
{
    word(o, node->active.control_word, 4);
    word(o, sim_cia402_status(&node->power), 4);
    integer(o, node->active.target);
    integer(o, (int64_t)sim_round(actual));
}

static const char *state_of(const sim_bus_t *bus)
{
    return bus->has_status && bus->told_state < cam_n_states
               ? cam_state_name((cam_state_t)bus->told_state)
               : "-";
}

void camsim_bus_trace_line(camsim_bus_t *b)
{
    camsim_out_t *o = &b->trace;
    const sim_bus_t *bus = &b->bus;
    const sim_bus_sample_t *s = &bus->sample;
    const double actual[] = {s->u_nm, s->x_nm, s->z_nm};
    camsim_out_integer(o, (int64_t)bus->n_steps);
    real(o, s->t_s, 9);
    real(o, s->turn * b->table.direction, 9);
    real(o, b->z_mm, 6);
    integer(o, bus->node[sim_bus_u].active.target);
    integer(o, (int64_t)sim_round(s->u_nm));
    camsim_out_char(o, ',');
    camsim_out_text(o, state_of(bus));
    word(o, bus->told_faults, 8);
    real(o, s->turn, 9);
    real(o, b->z_mm, 9);
    real(o, b->radius_mm, 9);
    real(o, (b->radius_mm - b->exact_mm) * SIM_NM_PER_MM, 3);
    integer(o, b->outputs.is_enabled ? 1 : 0);
    integer(o, b->outputs.is_fault ? 1 : 0);
    integer(o, b->outputs.is_in_cut ? 1 : 0);
    integer(o, (int64_t)bus->n_syncs);
    integer(o, bus->encoder_counts);
    for (int i = 0; i < hal_n_axes; i++) {
        drive_columns(o, &bus->node[sim_bus_u + i], actual[i]);
        integer(o, bus->node[sim_bus_u + i].active.velocity_offset);
    }
    drive_columns(o, &bus->node[sim_bus_spindle],
                  sim_spindle_true_rad_per_s(&bus->spindle) * (60000.0 / SIM_TWO_PI));
    camsim_out_char(o, '\n');
}

const char *camsim_bus_end_name(camsim_bus_end_t end)
{
    static const char *const name[] = {"running", "done", "fault", "lost", "timeout", "stopped"};
    return name[end];
}

static void number(cJSON *object, const char *key, double value)
{
    (void)cJSON_AddNumberToObject(object, key, value);
}

/// A number that exists only when there were samples.
static void sampled(cJSON *object, const camsim_bus_t *b, const char *key, double value)
{
    if (b->work.n > 0u) {
        number(object, key, value);
    } else {
        (void)cJSON_AddNullToObject(object, key);
    }
}

static void add_errors(cJSON *root, const camsim_bus_t *b)
{
    cJSON *form = cJSON_AddObjectToObject(root, "form_error_um");
    sampled(form, b, "max", b->work.max_um);
    sampled(form, b, "rms", sim_work_rms_um(&b->work));
    sampled(form, b, "roundness", sim_work_roundness_um(&b->work));
    sampled(form, b, "max_at_turn", b->work.max_turn);
    sampled(form, b, "max_at_z_mm", b->work.max_z_mm);
    number(form, "tolerance", b->options.common.tolerance_um);
    cJSON *following = cJSON_AddObjectToObject(root, "following_error_um");
    sampled(following, b, "max", b->following_max_um);
    sampled(following, b, "rms", sqrt(b->following_sum_um2 / (double)(b->work.n + 1u)));
}

static void add_cut(cJSON *root, const camsim_bus_t *b)
{
    cJSON *cut = cJSON_AddObjectToObject(root, "cut");
    number(cut, "turns", b->cut_turns);
    number(cut, "seconds", b->cut_s);
    number(cut, "samples", (double)b->work.n);
    number(cut, "blank_radius_mm", b->work.blank_mm);
    number(cut, "removed_mm3", b->work.removed_mm3);
    number(cut, "gouge_um", b->work.gouge_um);
}

static void add_faults(cJSON *root, const camsim_bus_t *b)
{
    cJSON *list = cJSON_AddArrayToObject(root, "faults");
    for (int i = 0; i < cam_n_faults; i++) {
        if ((b->faults >> i & 1u) != 0u) {
            (void)cJSON_AddItemToArray(list, cJSON_CreateString(cam_fault_name((cam_fault_t)i)));
        }
    }
    if (b->fault_s >= 0.0) {
        number(root, "fault_s", b->fault_s);
    }
    if (b->stopped_s >= 0.0) {
        number(root, "at_rest_s", b->stopped_s);
    }
}

static void add_drives(cJSON *root, const camsim_bus_t *b)
{
    static const char *const name[] = {"encoder", "u", "x", "z", "spindle"};
    cJSON *drives = cJSON_AddObjectToObject(root, "status_words");
    for (int i = sim_bus_u; i < sim_bus_n_nodes; i++) {
        number(drives, name[i], sim_cia402_status(&b->bus.node[i].power));
    }
}

bool camsim_bus_summary(camsim_bus_t *b)
{
    cJSON *root = cJSON_CreateObject();
    (void)cJSON_AddStringToObject(root, "camsim", CAMSIM_VERSION);
    (void)cJSON_AddStringToObject(root, "part", b->table.name);
    number(root, "table_crc32", b->table.crc32);
    (void)cJSON_AddStringToObject(root, "machine", b->options.common.cut.config.name);
    (void)cJSON_AddStringToObject(root, "end", camsim_bus_end_name(b->end));
    (void)cJSON_AddStringToObject(root, "state", state_of(&b->bus));
    add_faults(root, b);
    add_errors(root, b);
    add_cut(root, b);
    add_drives(root, b);
    number(root, "machine_time_s", b->bus.time_s);
    number(root, "ticks", (double)b->bus.n_steps);
    number(root, "syncs", (double)b->bus.n_syncs);
    number(root, "tick_hz", b->options.tick_hz);
    number(root, "unsent_frames", (double)b->link.n_unsent);
    char *text = cJSON_Print(root);
    cJSON_Delete(root);
    if (text == NULL) {
        return false;
    }
    camsim_out_text(&b->summary, text);
    camsim_out_char(&b->summary, '\n');
    cJSON_free(text);
    return true;
}
