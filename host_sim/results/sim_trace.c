// SPDX-License-Identifier: Apache-2.0
#include "sim_trace.h"
#include "cam_trace.h" // cam_trace_pop
#include "sim_units.h" // SIM_NM_PER_MM

static const char trace_header[] =
    "tick,t_s,turn,z_mm,u_set_nm,u_act_nm,state,faults,u_due_nm,"
    "true_turn,true_z_mm,radius_mm,error_nm,"
    "config,pos_q32,speed_q32,z_nm,u_set_q6,u_due_q6,"
    "in_clock,in_counts,in_index_counts,in_n_index,in_u_nm,in_x_nm,in_z_nm,in_inputs,in_request,"
    "out_u_nm,out_u_vel_q10,out_u_acc_q10,out_x_nm,out_x_vel_q10,out_x_acc_q10,"
    "out_z_nm,out_z_vel_q10,out_z_acc_q10,out_force_q6,out_spindle_mrpm,out_outputs";

void sim_trace_header(sim_out_t *o, const sim_cut_t *cut)
{
    sim_out_text(o, trace_header);
    sim_out_text(o, cut->session.table.is_swung ? ",swing_set_deg,swing_act_deg\n" : "\n");
}

/// Write a Q6 number, which has at most six decimals: 1/64 = 0.015625.
static void q6(sim_out_t *o, int32_t value_q6)
{
    sim_out_decimal_column(o, (int64_t)value_q6 * 15625, 6);
}

static void reading_columns(sim_out_t *o, const cam_tick_record_t *r, const sim_cut_t *cut)
{
    const sim_session_t *s = &cut->session;
    const double n_older =
        (double)(cut->firmware.tick - r->tick); // for records made before the first tick
    sim_out_integer(o, r->tick);
    sim_out_real_column(o, s->at.t_s - n_older * cut->port.lathe.step_s, 9);
    sim_out_real_column(o, s->table.direction * ((double)r->angle.pos_q32 / 4294967296.0), 9);
    sim_out_decimal_column(o, r->want.z_nm, 6);
    q6(o, r->want.u_set_q6);
    sim_out_integer_column(o, r->in.actual_nm[hal_axis_u]);
    sim_out_word_column(o, cam_state_name(r->want.state), (int)r->want.state);
    sim_out_hex_column(o, r->want.faults, 4);
    q6(o, r->want.u_due_q6);
    sim_out_real_column(o, s->at.turn, 9);
    sim_out_real_column(o, s->z_mm, 9);
    sim_out_real_column(o, s->radius_mm, 9);
    sim_out_real_column(o, (s->radius_mm - s->exact_mm) * SIM_NM_PER_MM, 3);
}

/// Write inputs and outputs of the tick.
static void record_columns(sim_out_t *o, const cam_tick_record_t *r)
{
    sim_out_integer_column(o, r->config);
    sim_out_integer_column(o, r->angle.pos_q32);
    sim_out_integer_column(o, r->angle.speed_q32);
    sim_out_integer_column(o, r->want.z_nm);
    sim_out_integer_column(o, r->want.u_set_q6);
    sim_out_integer_column(o, r->want.u_due_q6);
    sim_out_integer_column(o, r->in.clock);
    sim_out_integer_column(o, r->in.encoder.counts);
    sim_out_integer_column(o, r->in.encoder.index_counts);
    sim_out_integer_column(o, r->in.encoder.n_index);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_out_integer_column(o, r->in.actual_nm[i]);
    }
    sim_out_integer_column(o, r->in.inputs);
    sim_out_integer_column(o, r->in.request);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_out_integer_column(o, r->out[i].pos_nm);
        sim_out_integer_column(o, r->out[i].vel_q10);
        sim_out_integer_column(o, r->out[i].acc_q10);
    }
    sim_out_integer_column(o, r->force_q6);
    sim_out_integer_column(o, r->want.spindle_mrpm);
    sim_out_integer_column(o, r->want.outputs);
}

void sim_trace_drain(sim_out_t *o, sim_cut_t *cut)
{
    const double wanted = cut->options.trace_every;
    const uint32_t every = wanted >= 1.0 ? (uint32_t)wanted : 1u;
    cam_tick_record_t record;
    while (cam_trace_pop(&cut->firmware.machine.core->trace, &record)) {
        if (record.tick % every != 0u) {
            continue;
        }
        reading_columns(o, &record, cut);
        record_columns(o, &record);
        if (cut->session.table.is_swung) {
            sim_out_real_column(o, sim_port_swing_set_deg(&cut->port), 7);
            sim_out_real_column(o, cut->session.at.swing_deg, 7);
        }
        sim_out_char(o, '\n');
    }
}
