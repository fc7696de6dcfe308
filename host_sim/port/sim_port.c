// SPDX-License-Identifier: Apache-2.0
#include "sim_port.h"
#include "cam_plan.h"  // cam_plan_ticks
#include "hal_host.h"  // hal_host
#include "sim_units.h" // SIM_TWO_PI

void sim_port_init(sim_port_t *p, const sim_lathe_config_t *config, double x_nm, double z_nm,
                   uint64_t seed)
{
    *p = (sim_port_t){0};
    sim_lathe_init(&p->lathe, config, 1.0 / config->tick_hz, x_nm, z_nm, seed);
    sim_clock_init(&p->clock, seed);
    hal_host.tick_hz = (uint32_t)config->tick_hz;
    (void)hal_init(); // the host port cannot fail
    hal_host.slow.measures_u = true;
    const sim_drive_config_t *u = &config->drive[hal_axis_u];
    if (u->kind == sim_drive_force) {
        hal_host.slow.force = (hal_force_t){.quantum_un = (uint32_t)(u->force_quantum_n * 1e6),
                                            .latency_ns = (uint32_t)(u->delay_us * 1e3)};
    }
    hal_host.slow.has_edge_time = config->encoder.has_time_stamps != 0.0;
    p->n_shown = (uint32_t)cam_plan_ticks((uint32_t)config->tick_hz);
    for (int i = 0; i < hal_n_axes; i++) {
        sim_home_init(&p->home[i], &config->home[i], p->lathe.drive[i].pos_micro / SIM_MICRO);
    }
}

static uint32_t bit_if(bool is_set, uint32_t bit)
{
    return is_set ? bit : 0u;
}

/// Read a slide: its scale relative to the scale's zero, its home switch and its index.
static void sense_axis(sim_port_t *p, int axis)
{
    sim_home_t *h = &p->home[axis];
    const uint32_t on = (uint32_t)hal_in_home_u << axis;
    const uint32_t seen = (uint32_t)hal_in_index_u << axis;
    hal_host.in.axis_nm[axis] = sim_lathe_measured_micro(&p->lathe, axis) - h->zero_nm;
    if (!h->is_used) {
        return;
    }
    sim_home_look(h, p->lathe.drive[axis].pos_micro / SIM_MICRO, p->n_shown);
    hal_host.in.inputs =
        (hal_host.in.inputs & ~(on | seen)) | bit_if(h->is_on, on) | bit_if(h->is_seen, seen);
}

void sim_port_sense(sim_port_t *p)
{
    const sim_drive_t *drive = p->lathe.drive;
    const double swing_udeg = sim_drive_measured_micro(&drive[sim_lathe_swing]);
    hal_host.in.encoder = sim_lathe_encoder(&p->lathe);
    const double age_clocks =
        p->lathe.encoder.edge_age_s * hal_host_clock_hz * (1.0 + p->clock.drift);
    const uint32_t whole_clocks = (uint32_t)sim_round(sim_clamp(age_clocks, 0.0, UINT32_MAX));
    const uint32_t tick_clock = // time stamp of the next tick
        hal_host.clock + hal_host_clock_hz / hal_host.tick_hz + hal_host.late_clocks;
    hal_host.in.encoder.edge_clock = tick_clock - whole_clocks; // wraps by design
    hal_host.in.swing_q32 = (int32_t)sim_round(swing_udeg * SIM_Q32_PER_UDEG);
    for (int i = 0; i < hal_n_axes; i++) {
        sense_axis(p, i);
    }
    hal_host.in.axis_nm[hal_axis_z] += p->z_offset_nm;
}

/// @return the force of U in steps of the amplifier's input
static double force_n(void)
{
    const double quantum_n = hal_host.slow.force.quantum_un * 1e-6;
    const double wanted_n = hal_host.out.force_q6 / 64e3;
    return quantum_n > 0.0 ? sim_round(wanted_n / quantum_n) * quantum_n : 0.0;
}

/// Read the firmware's outputs. Without a new set-point the drive of the swing continues at the
/// speed of the last one; its angle may wrap.
static sim_setpoints_t wanted(sim_port_t *p)
{
    const hal_swing_t *swing = &hal_host.out.swing;
    const uint32_t gone_on_q32 = (uint32_t)p->swing_set_q32 + (uint32_t)swing->vel_q32;
    p->swing_set_q32 = p->n_swing != hal_host.out.n_swing ? swing->pos_q32 : (int32_t)gone_on_q32;
    p->n_swing = hal_host.out.n_swing;
    sim_setpoints_t set = {
        .spindle_rad_per_s = (double)hal_host.out.spindle_mrpm * (SIM_TWO_PI / 60000.0),
        .force_n = force_n(),
    };
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        set.micro[i] = i == sim_lathe_swing
                           ? (int32_t)sim_round(p->swing_set_q32 * SIM_UDEG_PER_Q32)
                           : hal_host.out.axis[i].pos_nm + p->home[i].zero_nm;
        set.is_enabled[i] = (hal_host.out.outputs & hal_out_enable) != 0u;
    }
    return set;
}

void sim_port_advance(sim_port_t *p)
{
    const sim_setpoints_t set = wanted(p);
    const sim_clock_step_t step = sim_clock_next(&p->clock, p->lathe.step_s, hal_host_clock_hz);
    sim_lathe_step_in(&p->lathe, &set, step.dt_s);
    hal_host.late_clocks += (uint32_t)step.late_clocks; // early: wraps by design
    p->lost_s += step.dt_s - p->lathe.step_s;
    p->time_s = (double)hal_host.n_ticks * p->lathe.step_s + p->lost_s;
    if (p->late_s > 0.0) {
        sim_lathe_linger(&p->lathe, &set, p->late_s);
        p->lost_s += p->late_s;
        p->time_s += p->late_s;
        p->late_s = 0.0;
    }
}

void sim_port_inject(sim_port_t *p, const sim_inject_t *inject, int direction)
{
    switch (inject->kind) {
    case sim_inject_estop:
        hal_host_fault_estop(true);
        break;
    case sim_inject_drive:
        hal_host_fault_drive(true);
        break;
    case sim_inject_bus:
        hal_host_fault_bus(true);
        break;
    case sim_inject_key:
        hal_host_turn_key(inject->value != 0.0);
        break;
    case sim_inject_u_limit:
        hal_host_u_limits(inject->value<0.0, inject->value> 0.0);
        break;
    case sim_inject_late_tick:
        hal_host_fault_late((uint32_t)inject->value);
        p->late_s += (double)hal_host.late_clocks / hal_host_clock_hz;
        break;
    case sim_inject_clock_drift:
        p->clock.drift = inject->value * 1e-6;
        break;
    case sim_inject_tick_jitter:
        p->clock.jitter = inject->value / 100.0;
        break;
    case sim_inject_tick_burst:
        p->clock.burst = inject->value / 100.0;
        break;
    case sim_inject_tick_twice:
        p->clock.twice = inject->value / 100.0;
        break;
    case sim_inject_z_offset:
        p->z_offset_nm = (int32_t)(inject->value * SIM_NM_PER_MM);
        break;
    default:
        sim_inject_apply(inject, &p->lathe, direction);
        break;
    }
}
