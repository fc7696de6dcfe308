// SPDX-License-Identifier: Apache-2.0
#include "sim_machine.h"
#include "hal_host.h"  // hal_host
#include "sim_units.h" // SIM_TWO_PI

sim_machine_config_t sim_machine_defaults(void)
{
    return (sim_machine_config_t){
        .tick_hz = 20000.0,
        .spindle = sim_spindle_defaults(),
        .encoder = sim_encoder_defaults(),
        .axis = {sim_drive_u_defaults(), sim_drive_x_defaults(), sim_drive_z_defaults()},
        .swing = sim_drive_swing_defaults(),
        .swing_range_deg = 30.0,
        .u_stroke_mm = 1.2,
        .spindle_limit_rpm = 3000.0,
        .x_start_mm = 2.0,
        .z_start_mm = 2.0,
    };
}

void sim_machine_init(sim_machine_t *m, const sim_machine_config_t *config, double x_nm,
                      double z_nm, uint64_t seed)
{
    const double start_nm[hal_n_axes] = {0.0, x_nm, z_nm};
    *m = (sim_machine_t){.period_s = 1.0 / config->tick_hz};
    sim_spindle_init(&m->spindle, &config->spindle);
    sim_encoder_init(&m->encoder, &config->encoder, m->spindle.turn, seed);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_drive_init(&m->axis[i], &config->axis[i], start_nm[i], m->period_s);
    }
    sim_drive_init(&m->swing, &config->swing, 0.0, m->period_s);
    hal_host.tick_hz = (uint32_t)config->tick_hz;
    (void)hal_init(); // the host port cannot fail
}

void sim_machine_sense(sim_machine_t *m)
{
    hal_host.in.encoder = sim_encoder_read(&m->encoder, m->spindle.turn);
    hal_host.in.swing_q32 = (int32_t)sim_round(sim_drive_measured_nm(&m->swing) * SIM_Q32_PER_UDEG);
    hal_host.in.axis_nm[hal_axis_u] = sim_drive_measured_nm(&m->axis[hal_axis_u]);
    hal_host.in.axis_nm[hal_axis_x] = sim_drive_measured_nm(&m->axis[hal_axis_x]);
    hal_host.in.axis_nm[hal_axis_z] = sim_drive_measured_nm(&m->axis[hal_axis_z]) + m->z_offset_nm;
}

static double spindle_set_rad_per_s(const sim_machine_t *m)
{
    const double told = (double)hal_host.out.spindle_mrpm * (SIM_TWO_PI / 60000.0);
    const double set = m->is_speed_forced ? m->forced_rad_per_s : told;
    return m->is_reversed ? -set : set;
}

static void linger(sim_machine_t *m, bool is_enabled)
{
    sim_spindle_step(&m->spindle, spindle_set_rad_per_s(m), m->late_s);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_drive_linger(&m->axis[i], m->late_s, is_enabled);
    }
    sim_drive_linger(&m->swing, m->late_s, is_enabled);
    m->lost_s += m->late_s;
    m->time_s += m->late_s;
    m->late_s = 0.0;
}

/// The drive goes on at the speed of its last set-point, which may wrap.
static void take_swing(sim_machine_t *m, bool is_enabled)
{
    const hal_swing_t *set = &hal_host.out.swing;
    const uint32_t gone_on_q32 = (uint32_t)m->swing_set_q32 + (uint32_t)set->vel_q32;
    m->swing_set_q32 = m->n_swing != hal_host.out.n_swing ? set->pos_q32 : (int32_t)gone_on_q32;
    m->n_swing = hal_host.out.n_swing;
    sim_drive_step(&m->swing, (int32_t)sim_round(m->swing_set_q32 / SIM_Q32_PER_UDEG), is_enabled);
}

void sim_machine_advance(sim_machine_t *m)
{
    const bool is_enabled = (hal_host.out.outputs & hal_out_enable) != 0u;
    sim_spindle_step(&m->spindle, spindle_set_rad_per_s(m), m->period_s);
    sim_drive_step(&m->axis[hal_axis_u], hal_host.out.axis[hal_axis_u].pos_nm, is_enabled);
    sim_drive_step(&m->axis[hal_axis_x], hal_host.out.axis[hal_axis_x].pos_nm, is_enabled);
    sim_drive_step(&m->axis[hal_axis_z], hal_host.out.axis[hal_axis_z].pos_nm, is_enabled);
    take_swing(m, is_enabled);
    m->time_s = (double)hal_host.n_ticks * m->period_s + m->lost_s;
    if (m->late_s > 0.0) {
        linger(m, is_enabled);
    }
}

void sim_machine_late(sim_machine_t *m, double percent)
{
    hal_host_fault_late((uint32_t)percent);
    m->late_s += (double)hal_host.late_clocks / hal_host_clock_hz;
}
