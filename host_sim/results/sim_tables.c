// SPDX-License-Identifier: Apache-2.0
#include "sim_tables.h"
#include "cam_tick.h"  // cam_trace_pop
#include "sim_units.h" // SIM_NM_PER_MM
#include <math.h>      // isnan

#define TRACE_COLUMNS                                                                              \
    "tick:0,t_s:9,turn:9,z_mm:6,u_set_nm:6,u_act_nm:0,state:s,faults:x4,u_due_nm:6,"               \
    "true_turn:9,true_z_mm:9,radius_mm:9,error_nm:3,"                                              \
    "config:0,pos_q32:0,speed_q32:0,z_nm:0,u_set_q6:0,u_due_q6:0,"                                 \
    "in_clock:0,in_counts:0,in_index_counts:0,in_n_index:0,in_u_nm:0,in_x_nm:0,in_z_nm:0,"         \
    "in_inputs:0,in_request:0,"                                                                    \
    "out_u_nm:0,out_u_vel_q10:0,out_u_acc_q10:0,out_x_nm:0,out_x_vel_q10:0,out_x_acc_q10:0,"       \
    "out_z_nm:0,out_z_vel_q10:0,out_z_acc_q10:0,out_force_q6:0,out_spindle_mrpm:0,out_outputs:0"

static const char trace_columns[] = TRACE_COLUMNS;
static const char swung_columns[] = TRACE_COLUMNS ",swing_set_deg:7,swing_act_deg:7";
#define SURFACE_COLUMNS "turn:8,z_mm:6,radius_mm:9,error_nm:3"
static const char removal_columns[] = "t_s:9,turn:9,z_mm:6,volume_mm3:9,rate_mm3_s:6,power_w:6,"
                                      "rate_force_n:6,chip_force_n:6";
static const char scallop_columns[] = "turn:8,z_mm:6,proud_um:6";
static const char sections_columns[] = "section:0,turn:8,z_mm:6,radius_mm:9,deviation_nm:3";

/// Append a Q6 number, which has at most six decimals: 1/64 = 0.015625.
static void add_q6(sim_rows_t *t, int32_t value_q6)
{
    sim_rows_add(t, (int64_t)value_q6 * 15625);
}

static void add_reading(sim_rows_t *t, const cam_tick_record_t *r, const sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    const double n_older =
        (double)(cut->firmware.tick - r->tick); // for records made before the first tick
    sim_rows_add(t, r->tick);
    sim_rows_real(t, s->at.t_s - n_older * cut->port.lathe.step_s);
    sim_rows_real(t, s->table.direction * ((double)r->angle.pos_q32 / 4294967296.0));
    sim_rows_add(t, r->want.z_nm);
    add_q6(t, r->want.u_set_q6);
    sim_rows_add(t, r->in.actual_nm[hal_axis_u]);
    sim_rows_add(t, (int64_t)r->want.state);
    sim_rows_add(t, r->want.faults);
    add_q6(t, r->want.u_due_q6);
    sim_rows_real(t, s->at.turn);
    sim_rows_real(t, s->z_mm);
    sim_rows_real(t, s->radius_mm);
    sim_rows_real(t, (s->radius_mm - s->exact_mm) * SIM_NM_PER_MM);
}

/// Append inputs and outputs of the tick.
static void add_record(sim_rows_t *t, const cam_tick_record_t *r)
{
    sim_rows_add(t, r->config);
    sim_rows_add(t, r->angle.pos_q32);
    sim_rows_add(t, r->angle.speed_q32);
    sim_rows_add(t, r->want.z_nm);
    sim_rows_add(t, r->want.u_set_q6);
    sim_rows_add(t, r->want.u_due_q6);
    sim_rows_add(t, r->in.clock);
    sim_rows_add(t, r->in.encoder.counts);
    sim_rows_add(t, r->in.encoder.index_counts);
    sim_rows_add(t, r->in.encoder.n_index);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_rows_add(t, r->in.actual_nm[i]);
    }
    sim_rows_add(t, r->in.inputs);
    sim_rows_add(t, r->in.request);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_rows_add(t, r->out[i].pos_nm);
        sim_rows_add(t, r->out[i].vel_q10);
        sim_rows_add(t, r->out[i].acc_q10);
    }
    sim_rows_add(t, r->force_q6);
    sim_rows_add(t, r->want.spindle_mrpm);
    sim_rows_add(t, r->want.outputs);
}

/// Append all firmware records since the last call.
static void drain(sim_rows_t *t, sim_cut_t *cut)
{
    const double wanted = cut->options.trace_every;
    const uint32_t every = wanted >= 1.0 ? (uint32_t)wanted : 1u;
    cam_tick_record_t record;
    while (cam_trace_pop(&cut->firmware.machine.core->trace, &record)) {
        if (record.tick % every != 0u) {
            continue;
        }
        add_reading(t, &record, cut);
        add_record(t, &record);
        if (cut->session.table.is_swung) {
            sim_rows_real(t, sim_port_swing_set_deg(&cut->port));
            sim_rows_real(t, cut->session.at.swing_deg);
        }
    }
}

static void add_slice(sim_rows_t *t, const sim_slice_t *slice)
{
    sim_rows_real(t, slice->t_s);
    sim_rows_real(t, slice->turn);
    sim_rows_real(t, slice->z_mm);
    sim_rows_real(t, slice->volume_mm3);
    sim_rows_real(t, slice->rate_mm3_s);
    sim_rows_real(t, slice->power_w);
    sim_rows_real(t, slice->rate_force_n);
    sim_rows_real(t, slice->chip_force_n);
}

static const char *surface_columns(const sim_session_t *s)
{
    return s->has_target ? SURFACE_COLUMNS ",control_nm:3" : SURFACE_COLUMNS;
}

void sim_tables_surface(sim_rows_t *t, const sim_session_t *s)
{
    sim_rows_open(t, surface_columns(s));
    for (int i = 0; i < sim_work_rows; i++) {
        for (int k = 0; k < sim_work_columns; k++) {
            const sim_cell_t *cell = &s->work.cell[i][k];
            if (cell->n > 0u) {
                sim_rows_real(t, (double)cell->turn);
                sim_rows_real(t, cell->z_mm);
                sim_rows_real(t, cell->radius_mm);
                sim_rows_real(t, (double)cell->error_nm);
                if (s->has_target) {
                    sim_rows_real(t, (double)s->control.cell[i][k].error_nm);
                }
            }
        }
    }
}

static void make_scallop(sim_rows_t *t, const sim_scallop_t *scallop, sim_design_t *design)
{
    for (int i = 0; i < sim_scallop_angles; i++) {
        for (int j = 0; j < sim_scallop_heights; j++) {
            sim_rows_real(t, (double)i / sim_scallop_angles);
            sim_rows_real(t, sim_scallop_height_mm(scallop, j));
            sim_rows_real(t, sim_scallop_proud_um(scallop, design, i, j));
        }
    }
}

static void add_place(sim_rows_t *t, int section, double turn, double z_mm, double drawn_mm,
                      double e_mm)
{
    sim_rows_add(t, section);
    sim_rows_real(t, turn);
    sim_rows_real(t, z_mm);
    sim_rows_real(t, drawn_mm + e_mm);
    sim_rows_real(t, e_mm * SIM_NM_PER_MM);
}

static void add_line(sim_rows_t *t, sim_session_t *s, int line)
{
    const double turn = (double)line / sim_sections_lines;
    for (int i = 0; i < sim_sections_heights; i++) {
        const double e_mm = s->sections.line_e_mm[line][i];
        const double z_mm = sim_sections_height_mm(&s->sections, i);
        if (!isnan(e_mm)) {
            add_place(t, 0, turn, z_mm, sim_design_radius_mm(&s->design, turn, z_mm), e_mm);
        }
    }
}

static void add_section(sim_rows_t *t, sim_session_t *s, int section)
{
    const bool has_lobes = s->design.shape == sim_shape_lobes;
    const double z_mm = s->sections.z_mm[section];
    for (int i = 0; i < sim_sections_places; i++) {
        const sim_place_t *at = &s->sections.section[section][i];
        const double turn = has_lobes ? at->turn : (double)i / sim_sections_places;
        if (!isnan(at->e_mm)) {
            add_place(t, section + 1, turn, z_mm,
                      has_lobes ? at->drawn_mm : sim_design_radius_mm(&s->design, turn, z_mm),
                      at->e_mm);
        }
    }
}

static void make_sections(sim_rows_t *t, sim_session_t *s)
{
    for (int i = 0; i < s->sections.n; i++) {
        add_section(t, s, i);
    }
    for (int i = 0; i < sim_sections_lines && s->design.shape != sim_shape_lobes; i++) {
        add_line(t, s, i);
    }
}

void sim_tables_open(sim_tables_t *t, const sim_cut_t *cut, const char *const *name)
{
    const char *const columns[sim_n_tables] = {
        [sim_table_trace] = cut->session.table.is_swung ? swung_columns : trace_columns,
        [sim_table_surface] = surface_columns(&cut->session),
        [sim_table_removal] = removal_columns,
        [sim_table_scallop] = scallop_columns,
        [sim_table_sections] = sections_columns,
    };
    for (int i = 0; i < sim_n_tables; i++) {
        sim_rows_free(&t->rows[i]);
        if (name[i] != NULL) {
            sim_rows_open(&t->rows[i], columns[i]);
        }
    }
}

void sim_tables_tick(sim_tables_t *t, sim_cut_t *cut)
{
    if (t->rows[sim_table_trace].columns != NULL) {
        drain(&t->rows[sim_table_trace], cut);
    }
    if (t->rows[sim_table_removal].columns != NULL && cut->has_slice) {
        add_slice(&t->rows[sim_table_removal], &cut->removal.slice);
    }
}

void sim_tables_end(sim_tables_t *t, sim_cut_t *cut)
{
    sim_session_t *s = &cut->session;
    if (t->rows[sim_table_surface].columns != NULL) {
        sim_tables_surface(&t->rows[sim_table_surface], s);
    }
    if (t->rows[sim_table_scallop].columns != NULL) {
        make_scallop(&t->rows[sim_table_scallop], &s->scallop, sim_session_played(s));
    }
    if (t->rows[sim_table_sections].columns != NULL) {
        make_sections(&t->rows[sim_table_sections], s);
    }
}

void sim_tables_free(sim_tables_t *t)
{
    for (int i = 0; i < sim_n_tables; i++) {
        sim_rows_free(&t->rows[i]);
    }
}
