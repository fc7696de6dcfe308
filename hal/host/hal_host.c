// SPDX-License-Identifier: Apache-2.0
#include "hal_host.h"
#include <stdio.h>  // fprintf, snprintf
#include <stdlib.h> // abort
#include <string.h> // memcpy, memset

hal_host_t hal_host;

enum { default_tick_hz = 20000 };

void hal_host_reset(uint32_t tick_hz)
{
    hal_host = (hal_host_t){.tick_hz = tick_hz,
                            .in.inputs = hal_in_drive_ready,
                            .slow = {.n_room = UINT32_MAX,
                                     .n_store = UINT32_MAX,
                                     .people = {.is_acknowledge_waived = true, .has_key = true}}};
}

int hal_init(void)
{
    hal_host_reset(hal_host.tick_hz != 0u ? hal_host.tick_hz : default_tick_hz);
    return 0;
}

uint32_t hal_tick_hz(void)
{
    return hal_host.tick_hz;
}

uint32_t hal_clock_hz(void)
{
    return hal_host_clock_hz;
}

bool hal_has_swing(void)
{
    return !hal_host.slow.has_no_swing;
}

bool hal_has_edge_time(void)
{
    return hal_host.slow.has_edge_time;
}

bool hal_measures_u(void)
{
    return hal_host.slow.measures_u;
}

hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    return hal_host.slow.scale[axis];
}

hal_force_t hal_force(void)
{
    return hal_host.slow.force;
}

hal_operator_t hal_operator(void)
{
    return hal_host.slow.people;
}

hal_memory_t hal_scope_memory(void)
{
    static int32_t words[hal_host_scope_words];
    return (hal_memory_t){
        .words = words, .n_words = hal_host_scope_words, .n_kept = hal_host.slow.n_kept};
}

void hal_scope_keep(const int32_t *words, uint32_t n)
{
    (void)words; // they survive in place
    hal_host.slow.n_kept = n;
}

void hal_tick_start(void) {}

void hal_idle(void)
{
    hal_host_tick();
}

void hal_halt(const char *why)
{
    (void)fprintf(stderr, "firmware halted: %s\n", why);
    abort();
}

hal_start_t hal_start(void)
{
    const hal_start_t start = hal_host.slow.start;
    return (hal_start_t){.reset = start.reset, .why = start.why != NULL ? start.why : ""};
}

hal_image_t hal_table_image(void)
{
    return hal_host.slow.table;
}

/// Two table slots; a download goes to the one that is not in use.
_Alignas(hal_table_grain) static uint8_t slots[2][hal_host_place_bytes];

/// @return whether this write succeeds (n_store in hal_host_t)
static bool stores(void)
{
    const bool is_good = hal_host.slow.n_store > 0u;
    hal_host.slow.n_store -= is_good ? 1u : 0u;
    return is_good;
}

bool hal_table_begin(uint32_t size)
{
    uint8_t *const slot = hal_host.slow.table.bytes == slots[0] ? slots[1] : slots[0];
    if (size > hal_host_place_bytes || !stores()) {
        return false;
    }
    (void)memset(slot, 0xFF, size);
    hal_host.slow.staged = (hal_image_t){.bytes = slot, .size = hal_host_place_bytes};
    return true;
}

bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    uint8_t *const slot = hal_host.slow.staged.bytes == slots[0] ? slots[0] : slots[1];
    const bool is_good = stores() && hal_host.slow.staged.bytes != NULL &&
                         offset <= hal_host_place_bytes && n <= hal_host_place_bytes - offset;
    if (is_good) {
        (void)memcpy(slot + offset, bytes, n);
    }
    return is_good;
}

hal_image_t hal_table_staged(void)
{
    return hal_host.slow.staged;
}

bool hal_table_commit(void)
{
    if (hal_host.slow.staged.bytes == NULL || !stores()) {
        return false;
    }
    hal_host.slow.table = hal_host.slow.staged;
    hal_host.slow.staged = (hal_image_t){0};
    return true;
}

static char params[hal_params_most_bytes];

hal_params_t hal_params_kept(void)
{
    return hal_host.slow.params;
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    const bool is_good = size > 0u && size <= sizeof params && stores();
    if (is_good && !hal_host.slow.forgets_params) {
        (void)memcpy(params, bytes, size);
        hal_host.slow.params = (hal_params_t){.bytes = params, .size = size};
    }
    return is_good;
}

hal_load_t hal_load(void)
{
    return hal_host.slow.load;
}

void hal_text(const char *line)
{
    char *const copy = hal_host.lines[hal_host.n_lines++ % hal_host_lines];
    (void)snprintf(copy, hal_host_line_bytes, "%s", line);
    (void)fprintf(stderr, "%s\n", line);
}

bool hal_host_can_receive(const hal_can_frame_t *frame)
{
    if (hal_host.slow.n_received - hal_host.slow.n_read == hal_host_can_frames) {
        return false;
    }
    hal_host.slow.received[hal_host.slow.n_received++ % hal_host_can_frames] = *frame;
    return true;
}

bool hal_can_read(hal_can_frame_t *frame)
{
    if (hal_host.slow.n_received == hal_host.slow.n_read) {
        return false;
    }
    *frame = hal_host.slow.received[hal_host.slow.n_read++ % hal_host_can_frames];
    return true;
}

bool hal_can_write(const hal_can_frame_t *frame)
{
    if (hal_host.slow.is_bus_off || hal_host.slow.n_room == 0u) {
        return false;
    }
    hal_host.slow.n_room--;
    hal_host.slow.sent[hal_host.slow.n_sent++ % hal_host_can_frames] = *frame;
    return true;
}

/// @return the true reading, distorted by the faults of the encoder
static hal_encoder_t distorted(void)
{
    hal_encoder_t reading = hal_host.in.encoder;
    reading.counts = hal_host.fault.is_encoder_stuck ? hal_host.fault.stuck_counts
                                                     : reading.counts + hal_host.fault.count_offset;
    // The index latch copies the distorted counter.
    reading.index_counts = hal_host.fault.is_encoder_stuck
                               ? hal_host.fault.stuck_counts
                               : reading.index_counts + hal_host.fault.count_offset;
    if (hal_host.fault.is_index_dead) {
        reading.index_counts = hal_host.fault.last_index.index_counts;
        reading.n_index = hal_host.fault.last_index.n_index;
    }
    return reading;
}

void hal_host_advance(void)
{
    hal_host.in.read = distorted();
    hal_host.clock += hal_host_clock_hz / hal_host.tick_hz + hal_host.late_clocks;
    hal_host.late_clocks = 0;
    hal_host.n_ticks++;
}

void hal_host_tick(void)
{
    hal_host_advance();
    cam_isr();
}

uint32_t hal_clock_isr(void)
{
    return hal_host.clock;
}

void hal_encoder_read_isr(hal_encoder_t *reading)
{
    *reading = hal_host.in.read;
}

int32_t hal_axis_read_nm_isr(hal_axis_t axis)
{
    return hal_host.in.axis_nm[axis];
}

int32_t hal_swing_read_q32_isr(void)
{
    return hal_host.in.swing_q32;
}

uint32_t hal_inputs_read_isr(void)
{
    return hal_host.in.inputs;
}

void hal_axis_write_isr(hal_axis_t axis, const hal_setpoint_t *setpoint)
{
    hal_host.out.axis[axis] = *setpoint;
}

void hal_force_write_isr(int32_t force_q6)
{
    hal_host.out.force_q6 = force_q6;
}

void hal_swing_write_isr(const hal_swing_t *setpoint)
{
    hal_host.out.swing = *setpoint;
    hal_host.out.n_swing++;
}

void hal_spindle_write_isr(int32_t speed_mrpm)
{
    hal_host.out.spindle_mrpm = speed_mrpm;
}

void hal_outputs_write_isr(uint32_t bits)
{
    hal_host.out.outputs = bits;
}

void hal_host_fault_counts(int32_t counts)
{
    hal_host.fault.count_offset += (uint32_t)counts;
}

void hal_host_fault_encoder_stuck(bool is_stuck)
{
    // The counter freezes at its present reading; when released it jumps to the true position.
    hal_host.fault.stuck_counts = distorted().counts;
    hal_host.fault.is_encoder_stuck = is_stuck;
}

void hal_host_fault_index_dead(bool is_dead)
{
    hal_host.fault.last_index = distorted();
    hal_host.fault.is_index_dead = is_dead;
}

void hal_host_fault_late(uint32_t percent)
{
    hal_host.late_clocks =
        (uint32_t)((uint64_t)hal_host_clock_hz * percent / 100u / hal_host.tick_hz);
}

/// Set or clear a bit of the inputs.
static void set_input(uint32_t bit, bool is_set)
{
    hal_host.in.inputs = is_set ? hal_host.in.inputs | bit : hal_host.in.inputs & ~bit;
}

void hal_host_fault_estop(bool is_pressed)
{
    set_input(hal_in_estop, is_pressed);
}

void hal_host_fault_drive(bool is_failed)
{
    set_input(hal_in_drive_ready, !is_failed);
}

void hal_host_fault_bus(bool is_lost)
{
    set_input(hal_in_bus_lost, is_lost);
}

void hal_host_u_limits(bool is_low, bool is_high)
{
    set_input(hal_in_limit_u_low, is_low);
    set_input(hal_in_limit_u_high, is_high);
}

void hal_host_press(bool is_pressed)
{
    set_input(hal_in_acknowledge, is_pressed);
}

void hal_host_turn_key(bool is_on)
{
    set_input(hal_in_key, is_on);
}
