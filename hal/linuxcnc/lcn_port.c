// SPDX-License-Identifier: Apache-2.0
#include "lcn_port.h"
#include "hal/hal.h"   // port functions, except hal_init(), whose name LinuxCNC uses
#include <stdatomic.h> // port.runs
#include <stdlib.h>    // abort

enum { clock_hz = 10000000, ns_per_clock = 100, ns_per_s = 1000000000, rate_part = 100 };

void (*lcn_port_print)(const char *line);

_Static_assert((int)lcn_u == (int)hal_axis_u && (int)lcn_x == (int)hal_axis_x &&
                   (int)lcn_z == (int)hal_axis_z && (int)lcn_n_axes == (int)hal_n_axes,
               "one numbering of the axes");

/// Written by the tick, except setup and runs.
static struct {
    lcn_setup_t setup;
    lcn_in_t in;
    lcn_out_t out;
    lcn_index_t index;
    uint32_t n_ticks;
    bool is_on_rate;
    _Atomic bool runs; ///< written by the slow thread
} port;

void lcn_port_init(const lcn_setup_t *setup)
{
    port.setup = *setup;
    port.in = (lcn_in_t){.is_estop = true};
    port.out = (lcn_out_t){0};
    port.index = (lcn_index_t){0};
    port.n_ticks = 0;
    port.is_on_rate = true;
    atomic_store(&port.runs, false);
}

void lcn_port_run(void)
{
    atomic_store(&port.runs, true);
}

/// @return whether the period matches the configured rate
static bool is_on_rate(int32_t period_ns)
{
    const int32_t due_ns = (int32_t)(ns_per_s / port.setup.tick_hz);
    const int32_t most_ns = due_ns / rate_part;
    return port.setup.is_nominal ||
           (period_ns >= due_ns - most_ns && period_ns <= due_ns + most_ns);
}

void lcn_port_tick(const lcn_in_t *in, int32_t turn_counts, lcn_out_t *out)
{
    port.in = *in;
    port.is_on_rate = is_on_rate(in->period_ns);
    if (atomic_load(&port.runs)) {
        lcn_index_step(&port.index, &in->spindle, turn_counts, !port.out.is_enabled);
        port.out.arms_index = port.index.arms;
        port.n_ticks++;
        cam_isr();
    } else {
        for (int i = 0; i < lcn_n_axes; i++) {
            port.out.pos_nm[i] = in->actual_nm[i];
        }
    }
    *out = port.out;
}

bool lcn_port_is_on_rate(void)
{
    return port.is_on_rate;
}

int32_t lcn_port_period_ns(void)
{
    return port.in.period_ns;
}

uint32_t hal_tick_hz(void)
{
    return port.setup.tick_hz;
}

bool hal_measures_u(void)
{
    return port.setup.is_measured[hal_axis_u];
}

hal_force_t hal_force(void)
{
    return (hal_force_t){.quantum_un = port.setup.force_quantum_un,
                         .latency_ns = port.setup.force_latency_ns};
}

hal_operator_t hal_operator(void)
{
    return (hal_operator_t){.has_acknowledge = true, .is_acknowledge_waived = port.setup.is_waived};
}

uint32_t hal_clock_hz(void)
{
    return clock_hz;
}

void hal_tick_start(void) {}

void hal_idle(void) {}

/// Ends the process with all HAL threads; then the hardware watchdog trips.
void hal_halt(const char *why)
{
    port.out = (lcn_out_t){.is_fault = true};
    lcn_port_print(why);
    abort();
}

void hal_text(const char *line)
{
    lcn_port_print(line);
}

uint32_t hal_clock_isr(void)
{
    if (port.setup.is_nominal) {
        return (uint32_t)((uint64_t)port.n_ticks * clock_hz / port.setup.tick_hz);
    }
    return (uint32_t)(port.in.now_ns / ns_per_clock);
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = (hal_encoder_t){
        .counts = (uint32_t)port.in.spindle.raw,
        .index_counts = port.index.counts,
        .n_index = port.index.n,
    };
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return port.setup.is_measured[axis] ? port.in.actual_nm[axis] : port.out.pos_nm[axis];
}

uint32_t hal_inputs_read_isr(void)
{
    const bool is_estop = port.in.is_estop || !port.is_on_rate;
    return (is_estop ? (uint32_t)hal_in_estop : 0u) |
           (port.in.is_drive_ready ? (uint32_t)hal_in_drive_ready : 0u) |
           (port.in.is_acknowledged ? (uint32_t)hal_in_acknowledge : 0u) |
           (port.in.is_u_on_home ? (uint32_t)hal_in_home_u : 0u) |
           (port.in.is_u_on_index ? (uint32_t)hal_in_index_u : 0u) |
           (port.in.is_u_at_low ? (uint32_t)hal_in_limit_u_low : 0u) |
           (port.in.is_u_at_high ? (uint32_t)hal_in_limit_u_high : 0u);
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    port.out.pos_nm[axis] = setpoint->pos_nm;
    port.out.vel_q10[axis] = setpoint->vel_q10;
    port.out.acc_q10[axis] = setpoint->acc_q10;
}

/// The analogue output rounds it to its quantum.
void hal_force_write_isr(int32_t force_q6)
{
    port.out.force_q6 = force_q6;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    port.out.spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    port.out.is_enabled = (bits & hal_out_enable) != 0u;
    port.out.is_fault = (bits & hal_out_fault) != 0u;
    port.out.is_in_cut = (bits & hal_out_in_cut) != 0u;
}
