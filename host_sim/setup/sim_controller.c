// SPDX-License-Identifier: Apache-2.0
#include "sim_config.h"
#include "cam_feasible.h" // cam_derived_limits_usual_mHz
#include "sim_units.h"    // SIM_TWO_PI
#include <math.h>         // ceil, floor, fmax, fmin, pow

bool sim_wishes_add(sim_wishes_t *w, const char *name, double value, const char *origin,
                    common_error_t *e)
{
    const cam_param_id_t id = cam_param_find(name);
    if (id >= cam_n_params && cam_param_is_retired(name)) {
        if (w->retired.text[0] == '\0') {
            (void)common_error(&w->retired, "%s: %.60s: retired and ignored", origin, name);
        }
        return true;
    }
    if (id >= cam_n_params) {
        return common_error(e, "%s: %.60s: no such parameter; see firmware/param/cam_param.h",
                            origin, name);
    }
    const cam_param_info_t *info = cam_param_info(id);
    if (value != floor(value) || value < info->min || value > info->max) {
        return common_error(e, "%s: %s = %.12g: out of range; give a whole number %d .. %d", origin,
                            name, value, (int)info->min, (int)info->max);
    }
    w->value[id] = (int32_t)value;
    w->is_given[id] = true;
    return true;
}

/// The probe of a rehearsal must exceed the steps of a coarse scale.
enum { probe_quanta = 3 };

typedef struct {
    cam_params_t *params;
    common_error_t *e;
    bool is_good;
} derive_t;

static void put(derive_t *d, cam_param_id_t id, double value)
{
    const cam_param_info_t *info = cam_param_info(id);
    const double whole = floor(value + 0.5);
    if (d->is_good && (!(whole >= info->min && whole <= info->max) ||
                       cam_param_set(d->params, id, (int32_t)whole) != cam_ok)) {
        d->is_good =
            common_error(d->e,
                         "machine file: %s = %.12g follows from the machine but must be %d .. %d; "
                         "change the machine, or set [controller] %s",
                         info->name, whole, (int)info->min, (int)info->max, info->name);
    }
}

static double lag_s(const sim_drive_config_t *axis)
{
    return axis->delay_us * 1e-6 + 2.0 * axis->damping / (SIM_TWO_PI * axis->bandwidth_hz);
}

/// The position loop of a force drive: as fast as its delay leaves margins of 6 dB and 30 degrees
/// over the mass +-30 %, and so slow that the modes on the scale stay below unity gain without a
/// notch. tools/tune designs a stiffer one.
static void derive_servo(derive_t *d, const sim_lathe_config_t *m)
{
    const sim_drive_config_t *u = &m->drive[hal_axis_u];
    const double tick_s = 1.0 / m->tick_hz;
    const double delay_s = u->delay_us * 1e-6 + 0.5 * tick_s + 1.0 / (SIM_TWO_PI * u->amplifier_hz);
    double crossover_hz = 0.07 / (delay_s + m->scale.latency_us * 1e-6);
    for (int i = 0; i < sim_mode_n; i++) {
        const sim_mode_config_t *mode = &m->mode[i];
        if (mode->hz > 0.0 && mode->is_on_scale != 0.0 && mode->share != 0.0) {
            crossover_hz = fmin(crossover_hz, mode->damping * mode->hz / sim_abs(mode->share));
        }
    }
    // 0.25 N/um per tick, which the servo holds, of m w^2 over a lead of 5 or more
    const double stiffness_n_per_m = u->mass_kg * pow(SIM_TWO_PI * crossover_hz, 2.0) / 5.0;
    const double most_integral_hz = 0.25e6 * m->tick_hz / (SIM_TWO_PI * stiffness_n_per_m);
    put(d, cam_param_k1_ns, 0.0);
    put(d, cam_param_k2_us2, 0.0);
    put(d, cam_param_lead_ns, (tick_s + delay_s) * 1e9);
    put(d, cam_param_servo_mass_g, u->mass_kg * 1e3);
    put(d, cam_param_servo_crossover_hz, fmax(crossover_hz, 1.0));
    put(d, cam_param_servo_lead_percent, 5000.0);
    put(d, cam_param_servo_pole_hz, floor(fmax(10.0, fmin(m->tick_hz / 5.0, 10.0 * crossover_hz))));
    put(d, cam_param_servo_integral_mHz, 1e3 * fmin(0.1 * crossover_hz, most_integral_hz));
    put(d, cam_param_servo_force_delay_ns, delay_s * 1e9);
    put(d, cam_param_servo_drag_mn_s_per_m, u->viscous_n_s_per_m * 1e3);
    put(d, cam_param_servo_friction_mn, u->friction_m_per_s2 * u->mass_kg * 1e3);
    put(d, cam_param_servo_stiffness_n_per_m, u->stiffness_n_per_m);
    put(d, cam_param_servo_force_limit_mn, u->force_limit_n * 1e3);
    put(d, cam_param_servo_continuous_mn, u->force_limit_n * 500.0);
}

static void derive_feed_forward(derive_t *d, const sim_lathe_config_t *m)
{
    const sim_drive_config_t *u = &m->drive[hal_axis_u];
    const double omega = SIM_TWO_PI * u->bandwidth_hz;
    const double half_tick_s = 0.5 / m->tick_hz;
    if (u->kind == sim_drive_force) {
        derive_servo(d, m);
    } else {
        put(d, cam_param_k1_ns, 2.0 * u->damping / omega * 1e9);
        put(d, cam_param_k2_us2, 1e12 / (omega * omega));
        put(d, cam_param_lead_ns, u->delay_us * 1e3 + half_tick_s * 1e9);
    }
    put(d, cam_param_u_scale_latency_ns, m->scale.latency_us * 1e3);
    put(d, cam_param_u_scale_nm,
        sim_clamp(u->quantum_micro, 0.0, cam_param_info(cam_param_u_scale_nm)->max));
    const cam_param_info_t *probe = cam_param_info(cam_param_probe_nm);
    put(d, cam_param_probe_nm, sim_clamp(probe_quanta * u->quantum_micro, probe->def, probe->max));
    const double xz_s =
        0.5 * (lag_s(&m->drive[hal_axis_x]) + lag_s(&m->drive[hal_axis_z])) + half_tick_s;
    put(d, cam_param_xz_lag_ns, xz_s * 1e9);
}

static void derive_limits(derive_t *d, const sim_lathe_config_t *m)
{
    const sim_drive_config_t *axis = m->drive;
    put(d, cam_param_u_stroke_nm, m->u_stroke_mm * SIM_NM_PER_MM);
    put(d, cam_param_u_speed_um_per_s, axis[hal_axis_u].speed_units_per_s * 1e3);
    put(d, cam_param_u_acceleration_mm_per_s2, axis[hal_axis_u].acceleration_units_per_s2);
    put(d, cam_param_x_speed_um_per_s, axis[hal_axis_x].speed_units_per_s * 1e3);
    put(d, cam_param_x_acceleration_mm_per_s2, axis[hal_axis_x].acceleration_units_per_s2);
    put(d, cam_param_z_speed_um_per_s, axis[hal_axis_z].speed_units_per_s * 1e3);
    put(d, cam_param_z_acceleration_mm_per_s2, axis[hal_axis_z].acceleration_units_per_s2);
    put(d, cam_param_spindle_limit_mrpm, m->spindle_limit_rpm * 1e3);
    put(d, cam_param_following_limit_nm,
        0.0); // the simulated drive measures: derived (cam_feasible.h)
    // The speed loop is first-order. Values beyond a parameter's range have no use, so they are
    // clamped.
    const sim_spindle_config_t *s = &m->spindle;
    put(d, cam_param_spindle_lag_us, sim_clamp(1e6 / s->bandwidth_rad_per_s, 0.0, 1e6));
    put(d, cam_param_spindle_acceleration_mrad_per_s2,
        sim_clamp(s->torque_Nm / s->inertia_kgm2 * 1e3, 1e3, 2e9));
}

/// A machine without a swing has speed 0; then nothing else is derived.
static void derive_swing(derive_t *d, const sim_lathe_config_t *m)
{
    const sim_drive_config_t *swing = &m->drive[sim_lathe_swing];
    put(d, cam_param_swing_speed_mdeg_per_s, swing->speed_units_per_s * 1e3);
    if (swing->speed_units_per_s > 0.0) {
        put(d, cam_param_swing_acceleration_deg_per_s2, swing->acceleration_units_per_s2);
        put(d, cam_param_swing_range_mdeg, m->swing_range_deg * 1e3);
        put(d, cam_param_swing_lag_ns, (lag_s(swing) + 0.5 / m->tick_hz) * 1e9);
    }
}

/// Derive the drawing's angle of the index, an index window wide enough for the edge noise (the
/// firmware adds it to the window for jumps), and an observer bandwidth that suits the tick rate.
static void derive_encoder(derive_t *d, const sim_lathe_config_t *m)
{
    const sim_encoder_config_t *c = &m->encoder;
    const double turn = sim_fraction(c->index_turn + 0.5) - 0.5;
    const double noise_counts = ceil(7.0 * c->jitter_counts); // two readings of +-3.47 rms each
    const uint32_t tick_hz = (uint32_t)m->tick_hz;
    const int32_t observer_mHz =
        cam_derived_limits_usual_mHz(d->params->observer_bandwidth_mHz, tick_hz);
    put(d, cam_param_counts_per_turn, c->counts_per_turn);
    put(d, cam_param_encoder_sign, c->sign);
    put(d, cam_param_index_offset_udeg, turn * SIM_UDEG_PER_TURN);
    put(d, cam_param_index_tolerance_counts, noise_counts);
    put(d, cam_param_observer_bandwidth_mHz, observer_mHz);
}

bool sim_controller_params(cam_params_t *params, const sim_lathe_config_t *machine, bool learns,
                           const sim_wishes_t *wishes, common_error_t *e)
{
    derive_t d = {.params = params, .e = e, .is_good = true};
    *params = cam_param_defaults();
    if (learns && machine->tick_hz >= cam_derived_limits_least_hz) {
        cam_param_learn(params, true);
    }
    derive_encoder(&d, machine);
    derive_feed_forward(&d, machine);
    derive_limits(&d, machine);
    derive_swing(&d, machine);
    for (uint32_t id = 0; id < cam_n_params; id++) {
        if (wishes->is_given[id]) {
            put(&d, (cam_param_id_t)id, wishes->value[id]);
        }
    }
    return d.is_good;
}
