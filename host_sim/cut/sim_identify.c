// SPDX-License-Identifier: Apache-2.0
#include "sim_identify.h"
#include "cam_machine.h" // cam_machine_excite, cam_machine_scope_set
#include <string.h>      // memcpy

enum { poll_ticks = 16 };

/// [s] machine time allowed for the controller to become ready, and for an excitation in addition
/// to its length.
static const double patience_s = 60.0;

static cam_machine_t *machine_of(sim_cut_t *cut)
{
    return &cut->firmware.machine;
}

/// Run some ticks with due injections, then the background work.
static void go_on(sim_cut_t *cut)
{
    for (int i = 0; i < poll_ticks; i++) {
        const sim_inject_t *what;
        while ((what = sim_session_next_inject(&cut->session, cut->port.time_s)) != NULL) {
            sim_port_inject(&cut->port, what, cut->session.table.direction);
        }
        sim_cut_idle(cut);
    }
    cam_machine_poll(machine_of(cut));
}

static bool refused(const char *what, cam_err_t err, common_error_t *e)
{
    return common_error(e, "%s: refused: %s", what, cam_err_text(err));
}

/// Enable, and wait until the axes are clear and the angle is known.
static bool make_ready(sim_cut_t *cut, common_error_t *e)
{
    const cam_err_t err = cam_machine_enable(machine_of(cut));
    if (err != cam_ok) {
        return refused("enable", err, e);
    }
    const double end_s = cut->port.time_s + patience_s;
    do {
        go_on(cut);
        const cam_state_t state = cut->firmware.state;
        if (state == cam_state_fault || cut->port.time_s > end_s) {
            return common_error(e, "homing: the controller is in %s, not ready; see camsim run",
                                cam_state_name(state));
        }
    } while (cut->firmware.state != cam_state_ready);
    return true;
}

static bool load_wave(sim_cut_t *cut, const sim_identify_options_t *o, common_error_t *e)
{
    cam_machine_t *m = machine_of(cut);
    const uint32_t n_bytes = o->n * (uint32_t)sizeof(int32_t);
    const uint8_t *bytes = (const uint8_t *)o->wave;
    cam_err_t err = cam_machine_wave_begin(m, n_bytes);
    if (err == cam_ok) {
        err = cam_machine_scope_set(m, cam_scope_field_wave_unit, o->is_force ? 1 : 0);
    }
    if (err == cam_ok) {
        err = cam_machine_wave_block(m, 0, bytes, n_bytes);
    }
    if (err == cam_ok) {
        err = cam_machine_wave_end(m, cam_crc32(0, bytes, n_bytes));
    }
    return err == cam_ok || refused("--wave", err, e);
}

static bool begin(sim_cut_t *cut, const sim_identify_options_t *o, common_error_t *e)
{
    cam_machine_t *m = machine_of(cut);
    cam_err_t err = cam_machine_scope_set(m, cam_scope_field_place_nm, o->place_nm);
    if (err == cam_ok) {
        err = cam_machine_scope_set(m, cam_scope_field_signals, (int32_t)o->signals);
    }
    if (err != cam_ok) {
        return refused("--signals", err, e);
    }
    const cam_verdict_t v = cam_machine_excite(m, o->n_periods, o->fade_ticks);
    switch (v.err) {
    case cam_ok:
        return true;
    case cam_err_wave_stroke:
        return common_error(e,
                            "--wave: U would be at %d nm; give a smaller wave, another "
                            "--place-nm, or --set u_stroke_nm above %d",
                            (int)v.value, (int)m->params.u_stroke_nm);
    case cam_err_wave_speed:
        return common_error(e, "--wave: U would move at %d um/s, u_speed_um_per_s is %d; %s",
                            (int)v.value, (int)m->params.u_speed_um_per_s,
                            "give a smaller or slower wave");
    case cam_err_wave_acceleration:
        return common_error(
            e, "--wave: U would accelerate by %d mm/s2, u_acceleration_mm_per_s2 is %d; %s",
            (int)v.value, (int)m->params.u_acceleration_mm_per_s2, "give a smaller or slower wave");
    case cam_err_wave_force:
        return common_error(e, "--wave: it would push U with %d mN, servo_force_limit_mn is %d; %s",
                            (int)v.value, (int)m->params.servo_force_limit_mn,
                            "give a smaller wave");
    case cam_err_wave_length:
        return common_error(e,
                            "--periods %u, --fade-ticks %u: too short or too long; give 1 or "
                            "more, 16 .. 65535, and at most %d ticks in all",
                            o->n_periods, o->fade_ticks, (int)v.value);
    case cam_err_wave_clear:
        return common_error(e, "--wave: X must stand at %d nm at least; give more x_start_mm",
                            (int)v.value);
    default:
        return refused("excite", v.err, e);
    }
}

bool sim_identify_run(sim_cut_t *cut, const sim_identify_options_t *options, common_error_t *e)
{
    cam_machine_t *m = machine_of(cut);
    if (!make_ready(cut, e) || !load_wave(cut, options, e) || !begin(cut, options, e)) {
        return false;
    }
    const double begin_s = cut->port.time_s;
    while (m->identify.phase != cam_identify_none) {
        go_on(cut);
        if (options->alive_s <= 0.0 || cut->port.time_s < begin_s + options->alive_s) {
            cam_machine_keep_alive(m);
        }
        if (cut->port.time_s > begin_s + 2.0 * patience_s) {
            return common_error(e, "excite: not ended after %.0f s; this is a fault of camsim",
                                2.0 * patience_s);
        }
    }
    return true;
}

cam_excited_t sim_identify_end(const sim_cut_t *cut)
{
    return cut->firmware.machine.identify.excited;
}

uint32_t sim_identify_n_played(const sim_cut_t *cut)
{
    const cam_machine_t *m = &cut->firmware.machine;
    return m->scope.ring.n_rows > m->identify.n_fall ? m->scope.ring.n_rows - m->identify.n_fall
                                                     : 0u;
}
