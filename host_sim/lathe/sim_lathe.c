// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // sim_abs

sim_lathe_config_t sim_lathe_defaults(void)
{
    return (sim_lathe_config_t){
        .tick_hz = 20000.0,
        .spindle = sim_spindle_defaults(),
        .encoder = sim_encoder_defaults(),
        .drive = {[hal_axis_u] = sim_drive_u_defaults(),
                  [hal_axis_x] = sim_drive_x_defaults(),
                  [hal_axis_z] = sim_drive_z_defaults(),
                  [sim_lathe_swing] = sim_drive_swing_defaults()},
        .swing_range_deg = 30.0,
        .u_stroke_mm = 1.2,
        .spindle_limit_rpm = 3000.0,
        .x_start_mm = 2.0,
        .z_start_mm = 2.0,
        .tool_nose_mm = -1.0,
    };
}

void sim_lathe_init(sim_lathe_t *l, const sim_lathe_config_t *config, double step_s, double x_nm,
                    double z_nm, uint64_t seed)
{
    const double start_micro[sim_lathe_n_drives] = {[hal_axis_x] = x_nm, [hal_axis_z] = z_nm};
    *l = (sim_lathe_t){.step_s = step_s};
    sim_spindle_init(&l->spindle, &config->spindle);
    sim_encoder_init(&l->encoder, &config->encoder, l->spindle.turn, seed);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_init(&l->drive[i], &config->drive[i], start_micro[i], step_s);
    }
}

/// @return the speed that the spindle is led to: an injected fault goes before the set-point
static double spindle_rad_per_s(const sim_lathe_t *l, const sim_setpoints_t *set)
{
    const double wanted = l->is_speed_forced ? l->forced_rad_per_s : set->spindle_rad_per_s;
    return l->is_reversed ? -wanted : wanted;
}

void sim_lathe_step(sim_lathe_t *l, const sim_setpoints_t *set)
{
    sim_spindle_step(&l->spindle, spindle_rad_per_s(l, set), l->step_s);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_step(&l->drive[i], set->micro[i], set->is_enabled[i]);
    }
}

void sim_lathe_linger(sim_lathe_t *l, const sim_setpoints_t *set, double late_s)
{
    sim_spindle_step(&l->spindle, spindle_rad_per_s(l, set), late_s);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_linger(&l->drive[i], late_s, set->is_enabled[i]);
    }
}

/// The last reading with the faults of the encoder; the index latch copies the counter with them.
static hal_encoder_t distorted(const sim_lathe_t *l)
{
    hal_encoder_t reading = l->true_reading;
    reading.counts = l->is_encoder_stuck ? l->stuck_counts : reading.counts + l->count_offset;
    reading.index_counts =
        l->is_encoder_stuck ? l->stuck_counts : reading.index_counts + l->count_offset;
    if (l->is_index_dead) {
        reading.index_counts = l->last_index.index_counts;
        reading.n_index = l->last_index.n_index;
    }
    return reading;
}

hal_encoder_t sim_lathe_encoder(sim_lathe_t *l)
{
    l->true_reading = sim_encoder_read(&l->encoder, l->spindle.turn);
    return distorted(l);
}

void sim_lathe_stick_encoder(sim_lathe_t *l)
{
    // Faults add up: what was lost before the counter got stuck stays lost.
    l->stuck_counts = distorted(l).counts;
    l->is_encoder_stuck = true;
}

void sim_lathe_kill_index(sim_lathe_t *l)
{
    l->last_index = distorted(l);
    l->is_index_dead = true;
}

sim_sample_t sim_lathe_sample(const sim_lathe_t *l, double t_s)
{
    return (sim_sample_t){
        .t_s = t_s,
        .turn = l->spindle.turn,
        .u_nm = l->drive[hal_axis_u].pos_micro,
        .x_nm = l->drive[hal_axis_x].pos_micro,
        .z_nm = l->drive[hal_axis_z].pos_micro,
        .swing_deg = l->drive[sim_lathe_swing].pos_micro * 1e-6,
    };
}

bool sim_lathe_drive_rests(const sim_lathe_t *l, int drive)
{
    return sim_abs(l->drive[drive].vel_micro_per_s) < 1000.0;
}

bool sim_lathe_spindle_rests(const sim_lathe_t *l)
{
    return sim_abs(l->spindle.speed_rad_per_s) < 0.01;
}
