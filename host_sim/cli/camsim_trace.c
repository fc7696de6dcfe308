// SPDX-License-Identifier: Apache-2.0
#include "camsim_trace.h"
#include "cam_trace.h" // cam_trace_pop
#include "sim_units.h" // SIM_NM_PER_MM

static const char trace_header[] =
    "tick,t_s,turn,z_mm,u_set_nm,u_act_nm,state,faults,u_due_nm,"
    "true_turn,true_z_mm,radius_mm,error_nm,"
    "config,pos_q32,speed_q32,z_nm,u_set_q6,u_due_q6,"
    "in_clock,in_counts,in_index_counts,in_n_index,in_u_nm,in_x_nm,in_z_nm,in_inputs,in_request,"
    "out_u_nm,out_u_vel_q10,out_u_acc_q10,out_x_nm,out_x_vel_q10,out_x_acc_q10,"
    "out_z_nm,out_z_vel_q10,out_z_acc_q10,out_spindle_mrpm,out_outputs";

void camsim_trace_header(camsim_out_t *o, const sim_cut_t *cut)
{
    camsim_out_text(o, trace_header);
    camsim_out_text(o, cut->table.is_swung ? ",swing_set_deg,swing_act_deg\n" : "\n");
}

static void integer(camsim_out_t *o, int64_t value)
{
    camsim_out_char(o, ',');
    camsim_out_integer(o, value);
}

static void decimal(camsim_out_t *o, int64_t value, int decimals)
{
    camsim_out_char(o, ',');
    camsim_out_decimal(o, value, decimals);
}

static void real(camsim_out_t *o, double value, int decimals)
{
    camsim_out_char(o, ',');
    camsim_out_real(o, value, decimals);
}

/// Q6 has exactly six decimals at most: 1/64 = 0.015625.
static void q6(camsim_out_t *o, int32_t value_q6)
{
    decimal(o, (int64_t)value_q6 * 15625, 6);
}

static void hexadecimal(camsim_out_t *o, uint32_t value)
{
    camsim_out_text(o, ",0x");
    for (int shift = 28; shift >= 0; shift -= 4) {
        if (shift < 16 || value >> 16 != 0u) {
            camsim_out_char(o, "0123456789abcdef"[(value >> shift) & 15u]);
        }
    }
}

static void reading_columns(camsim_out_t *o, const cam_tick_record_t *r, const sim_cut_t *cut)
{
    const double behind =
        (double)(sim_cut_status(cut)->tick - r->tick); // records made before the first tick
    camsim_out_integer(o, r->tick);
    real(o, cut->sample_s - behind * cut->machine.period_s, 9);
    real(o, (double)r->angle.pos_q32 / 4294967296.0, 9);
    decimal(o, r->want.z_nm, 6);
    q6(o, r->want.u_set_q6);
    integer(o, r->in.actual_nm[hal_axis_u]);
    camsim_out_char(o, ',');
    camsim_out_text(o, cam_state_name(r->want.state));
    hexadecimal(o, r->want.faults);
    q6(o, r->want.u_due_q6);
    real(o, cut->true_turn, 9);
    real(o, cut->z_mm, 9);
    real(o, cut->radius_mm, 9);
    real(o, (cut->radius_mm - cut->exact_mm) * SIM_NM_PER_MM, 3);
}

static void sensed_columns(camsim_out_t *o, const cam_tick_record_t *r)
{
    integer(o, r->config);
    integer(o, r->angle.pos_q32);
    integer(o, r->angle.speed_q32);
    integer(o, r->want.z_nm);
    integer(o, r->want.u_set_q6);
    integer(o, r->want.u_due_q6);
    integer(o, r->in.clock);
    integer(o, r->in.encoder.counts);
    integer(o, r->in.encoder.index_counts);
    integer(o, r->in.encoder.n_index);
    for (int i = 0; i < hal_n_axes; i++) {
        integer(o, r->in.actual_nm[i]);
    }
    integer(o, r->in.inputs);
    integer(o, r->in.request);
}

static void written_columns(camsim_out_t *o, const cam_tick_record_t *r)
{
    for (int i = 0; i < hal_n_axes; i++) {
        integer(o, r->out[i].pos_nm);
        integer(o, r->out[i].vel_q10);
        integer(o, r->out[i].acc_q10);
    }
    integer(o, r->want.spindle_mrpm);
    integer(o, r->want.outputs);
}

void camsim_trace_drain(camsim_out_t *o, sim_cut_t *cut)
{
    cam_tick_record_t record;
    while (cam_trace_pop(sim_firmware_trace(&cut->firmware), &record)) {
        reading_columns(o, &record, cut);
        sensed_columns(o, &record);
        written_columns(o, &record);
        if (cut->table.is_swung) {
            real(o, sim_machine_swing_set_deg(&cut->machine), 7);
            real(o, cut->swing_deg, 7);
        }
        camsim_out_char(o, '\n');
    }
}

void camsim_removal_header(camsim_out_t *o)
{
    camsim_out_text(o, "t_s,turn,z_mm,volume_mm3,rate_mm3_s,power_w,rate_force_n,chip_force_n\n");
}

void camsim_removal(camsim_out_t *o, const sim_slice_t *slice)
{
    camsim_out_real(o, slice->t_s, 9);
    real(o, slice->turn, 9);
    real(o, slice->z_mm, 6);
    real(o, slice->volume_mm3, 9);
    real(o, slice->rate_mm3_s, 6);
    real(o, slice->power_w, 6);
    real(o, slice->rate_force_n, 6);
    real(o, slice->chip_force_n, 6);
    camsim_out_char(o, '\n');
}

static void surface_cell(camsim_out_t *o, const sim_cell_t *cell)
{
    camsim_out_real(o, (double)cell->turn, 8);
    real(o, cell->z_mm, 6);
    real(o, cell->radius_mm, 9);
    real(o, (double)cell->error_nm, 3);
    camsim_out_char(o, '\n');
}

void camsim_surface(camsim_out_t *o, const sim_work_t *work)
{
    camsim_out_text(o, "turn,z_mm,radius_mm,error_nm\n");
    for (int i = 0; i < sim_work_rows; i++) {
        for (int k = 0; k < sim_work_columns; k++) {
            if (work->cell[i][k].n > 0u) {
                surface_cell(o, &work->cell[i][k]);
            }
        }
    }
}

void camsim_scallop(camsim_out_t *o, const sim_scallop_t *scallop, sim_design_t *design)
{
    camsim_out_text(o, "turn,z_mm,proud_um\n");
    for (int i = 0; i < sim_scallop_angles; i++) {
        for (int j = 0; j < sim_scallop_heights; j++) {
            camsim_out_real(o, (double)i / sim_scallop_angles, 8);
            real(o, sim_scallop_height_mm(scallop, j), 6);
            real(o, sim_scallop_proud_um(scallop, design, i, j), 6);
            camsim_out_char(o, '\n');
        }
    }
}
