// SPDX-License-Identifier: Apache-2.0
#include "sim_lathe.h"
#include "sim_units.h" // sim_cosine, sim_abs, SIM_TWO_PI

void sim_lathe_init(sim_lathe_t *l, const sim_lathe_config_t *config, double step_s, double x_nm,
                    double z_nm, uint64_t seed)
{
    const double start_micro[sim_lathe_n_drives] = {[hal_axis_x] = x_nm, [hal_axis_z] = z_nm};
    *l = (sim_lathe_t){
        .step_s = step_s,
        .chip = config->chip,
        .is_scale_ideal = config->mode[0].hz <= 0.0 && config->mode[1].hz <= 0.0 &&
                          config->scale.latency_us <= 0.0 && config->scale.error_nm <= 0.0,
        .runout_nm = config->runout_um * 1e3,
        .runout_2_nm = config->runout_2_um * 1e3,
    };
    sim_spindle_init(&l->spindle, &config->spindle);
    sim_encoder_init(&l->encoder, &config->encoder, l->spindle.turn, seed);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_init(&l->drive[i], &config->drive[i], start_micro[i], step_s);
    }
    for (int i = 0; i < sim_mode_n; i++) {
        sim_mode_init(&l->mode[i], &config->mode[i]);
    }
    sim_scale_init(&l->scale, &config->scale, 0.0, step_s);
}

/// Move the modes and the scale of U with its slide over a step in two pieces.
/// @param from  state of the slide before the step
static void follow_u(sim_lathe_t *l, sim_drive_place_t from, double first_s, double second_s)
{
    const sim_drive_t *u = &l->drive[hal_axis_u];
    if (l->is_scale_ideal) {
        return;
    }
    const sim_drive_place_t middle = first_s > 0.0 ? u->middle : from;
    const sim_mode_travel_t first = {{from.pos_micro, middle.pos_micro},
                                     {from.vel_micro_per_s, middle.vel_micro_per_s}};
    const sim_mode_travel_t second = {{middle.pos_micro, u->pos_micro},
                                      {middle.vel_micro_per_s, u->vel_micro_per_s}};
    double pos_micro = u->pos_micro;
    double vel_micro_per_s = u->vel_micro_per_s;
    for (int i = 0; i < sim_mode_n; i++) {
        sim_mode_t *m = &l->mode[i];
        sim_mode_step(m, &first, first_s);
        sim_mode_step(m, &second, second_s);
        pos_micro += m->is_on_scale ? sim_mode_tip_micro(m) : 0.0;
        vel_micro_per_s += m->is_on_scale ? m->share * m->vel_micro_per_s : 0.0;
    }
    sim_scale_push(&l->scale, pos_micro, vel_micro_per_s);
}

/// @return commanded spindle speed; an injected fault overrides the set-point
static double spindle_rad_per_s(const sim_lathe_t *l, const sim_setpoints_t *set)
{
    const double wanted = l->is_speed_forced ? l->forced_rad_per_s : set->spindle_rad_per_s;
    return l->is_reversed ? -wanted : wanted;
}

void sim_lathe_step(sim_lathe_t *l, const sim_setpoints_t *set)
{
    const sim_drive_t *u = &l->drive[hal_axis_u];
    const sim_drive_place_t from = {u->pos_micro, u->vel_micro_per_s};
    sim_spindle_step(&l->spindle, spindle_rad_per_s(l, set), l->step_s);
    sim_drive_push(&l->drive[hal_axis_u], l->is_force_reversed ? -set->force_n : set->force_n);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_step(&l->drive[i], set->micro[i], set->is_enabled[i]);
    }
    l->unread_s += l->step_s;
    follow_u(l, from, u->middle_s, l->step_s - u->middle_s);
}

void sim_lathe_step_in(sim_lathe_t *l, const sim_setpoints_t *set, double dt_s)
{
    if (dt_s == l->step_s) {
        sim_lathe_step(l, set);
        return;
    }
    const sim_drive_t *u = &l->drive[hal_axis_u];
    const sim_drive_place_t from = {u->pos_micro, u->vel_micro_per_s};
    sim_spindle_step(&l->spindle, spindle_rad_per_s(l, set), dt_s);
    sim_drive_push(&l->drive[hal_axis_u], l->is_force_reversed ? -set->force_n : set->force_n);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_step_in(&l->drive[i], set->micro[i], set->is_enabled[i], dt_s);
    }
    l->unread_s += dt_s;
    follow_u(l, from, u->middle_s, dt_s - u->middle_s);
}

void sim_lathe_linger(sim_lathe_t *l, const sim_setpoints_t *set, double late_s)
{
    const sim_drive_t *u = &l->drive[hal_axis_u];
    const sim_drive_place_t from = {u->pos_micro, u->vel_micro_per_s};
    sim_spindle_step(&l->spindle, spindle_rad_per_s(l, set), late_s);
    for (int i = 0; i < sim_lathe_n_drives; i++) {
        sim_drive_linger(&l->drive[i], late_s, set->is_enabled[i]);
    }
    l->unread_s += late_s;
    follow_u(l, from, 0.0, late_s);
}

void sim_lathe_bite(sim_lathe_t *l, double depth_mm)
{
    const double turns_per_s = l->spindle.speed_rad_per_s / SIM_TWO_PI;
    const double z_mm_per_s = l->drive[hal_axis_z].vel_micro_per_s / SIM_MICRO;
    l->chip_n = sim_chip_force_n(&l->chip, depth_mm, z_mm_per_s, turns_per_s);
    sim_drive_disturb(&l->drive[hal_axis_u], l->push_n - l->chip_n);
}

int32_t sim_lathe_measured_micro(const sim_lathe_t *l, int drive)
{
    const sim_drive_t *d = &l->drive[drive];
    if (drive == hal_axis_u && l->is_scale_stuck) {
        return l->stuck_micro;
    }
    if (drive != hal_axis_u || d->is_blocked || l->is_scale_ideal) {
        return sim_drive_measured_micro(d);
    }
    return sim_drive_reported_micro(d, sim_scale_read_micro(&l->scale));
}

/// The last reading with the encoder's faults, which the index latch copies too.
static hal_encoder_t distorted(const sim_lathe_t *l)
{
    hal_encoder_t reading = l->true_reading;
    const uint32_t offset = l->count_offset + (uint32_t)(int64_t)sim_floor(l->rated_counts);
    const uint32_t dither = l->n_readings * 7919u % (l->dither_counts + 1u);
    reading.counts = l->is_encoder_stuck ? l->stuck_counts + dither : reading.counts + offset;
    reading.index_counts = l->is_encoder_stuck ? l->stuck_counts : reading.index_counts + offset;
    if (l->is_index_dead) {
        reading.index_counts = l->last_index.index_counts;
        reading.n_index = l->last_index.n_index;
    }
    return reading;
}

hal_encoder_t sim_lathe_encoder(sim_lathe_t *l)
{
    const uint32_t before = l->true_reading.counts;
    l->true_reading = sim_encoder_read(&l->encoder, l->spindle.turn);
    l->rated_counts += l->count_rate * (int32_t)(l->true_reading.counts - before);
    l->n_readings++;
    if (l->encoder.config.has_time_stamps != 0.0) {
        sim_encoder_stamp(&l->encoder, l->spindle.turn,
                          sim_spindle_true_rad_per_s(&l->spindle) / SIM_TWO_PI, l->unread_s);
    }
    l->unread_s = 0.0;
    return distorted(l);
}

void sim_lathe_stick_encoder(sim_lathe_t *l)
{
    // Faults add up: counts lost before the counter stuck stay lost.
    l->stuck_counts = distorted(l).counts;
    l->is_encoder_stuck = true;
}

void sim_lathe_kill_index(sim_lathe_t *l)
{
    l->last_index = distorted(l);
    l->is_index_dead = true;
}

/// @return [nm] distance of the tip from the slide
static double tip_beside_nm(const sim_lathe_t *l)
{
    double nm = -1e3 * sim_chip_bend_um(&l->chip, l->chip_n);
    for (int i = 0; i < sim_mode_n && !l->is_scale_ideal; i++) {
        nm += sim_mode_tip_micro(&l->mode[i]);
    }
    return nm;
}

/// @return [nm] change of the tool's distance by the spindle's run-out
static double runout_nm(const sim_lathe_t *l)
{
    const double turn = l->spindle.turn;
    return l->runout_nm * sim_cosine(turn) + l->runout_2_nm * sim_cosine(2.0 * turn);
}

sim_sample_t sim_lathe_sample(const sim_lathe_t *l, double t_s)
{
    const bool has_runout = l->runout_nm > 0.0 || l->runout_2_nm > 0.0;
    return (sim_sample_t){
        .t_s = t_s,
        .turn = l->spindle.turn,
        .u_nm = l->drive[hal_axis_u].pos_micro + tip_beside_nm(l),
        .x_nm = l->drive[hal_axis_x].pos_micro + (has_runout ? runout_nm(l) : 0.0),
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
