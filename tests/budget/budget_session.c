// SPDX-License-Identifier: Apache-2.0
#include "budget_session.h"
#include "cam_machine_inner.h" // cam_machine_jog, cam_machine_excite, cam_machine_hold
#include "cam_table.h"         // cam_crc32
#include "fixture_newer.h"     // fixture_newer_way
#include "fixture_shaft.h"     // fixture_shaft_make
#include "hal_host.h"          // hal_host
#include <math.h>              // cos, sin
#include <stdio.h>             // printf

enum { tick_hz = 20000, patience = 60000 };

void budget_spread_add(budget_spread_t *s, uint32_t n_instructions)
{
    s->min = s->n == 0u || n_instructions < s->min ? n_instructions : s->min;
    s->max = s->n == 0u || n_instructions > s->max ? n_instructions : s->max;
    s->n++;
    s->sum += n_instructions;
}

uint32_t budget_spread_mean(const budget_spread_t *s)
{
    return s->n > 0u ? (uint32_t)((s->sum + s->n / 2u) / s->n) : 0u;
}

void budget_spread_print(const char *session, const char *what,
                         const budget_spread_t ticks[cam_n_states])
{
    for (int state = 0; state < cam_n_states; state++) {
        const budget_spread_t *s = &ticks[state];
        if (s->n > 0u) {
            printf("%-10s %-4s %-12s %4lu .. %4lu, mean %4lu instructions, %lu ticks\n", session,
                   what, cam_state_name((cam_state_t)state), (unsigned long)s->min,
                   (unsigned long)s->max, (unsigned long)budget_spread_mean(s),
                   (unsigned long)s->n);
        }
    }
}

static bool set(fixture_rig_t *rig, cam_param_id_t id, int32_t value)
{
    return fixture_rig_set(rig, id, value) == cam_ok;
}

bool budget_session_open(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part)
{
    fixture_rig_init(rig, part, tick_hz);
    rig->isr = isr;
    bool is_set = set(rig, cam_param_following_limit_nm, 10000000);
    if (part->speed != NULL) {
        is_set = is_set && set(rig, cam_param_spindle_acceleration_mrad_per_s2, 2000000000) &&
                 set(rig, cam_param_spindle_mrpm, 2000000);
        rig->lathe.ramp_rpm = 50.0;
    }
    return is_set;
}

bool budget_session_swung(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part)
{
    return budget_session_open(rig, isr, part) && set(rig, cam_param_spindle_mrpm, 2000000) &&
           set(rig, cam_param_swing_speed_mdeg_per_s, 100000000) &&
           set(rig, cam_param_swing_acceleration_deg_per_s2, 100000000) &&
           set(rig, cam_param_swing_following_limit_mdeg, 90000) &&
           set(rig, cam_param_swing_lag_ns, 1000000);
}

/// On the 1 mm of the short skirt the feed swings by a half about its mean.
static void half_more(double z_nm, double way[3])
{
    const double k = 2.0 * 3.14159265358979323846 / 1e6;
    way[0] = 0.5 * (1.0 - cos(k * z_nm)) / k;
    way[1] = 0.5 * sin(k * z_nm);
    way[2] = 0.5 * k * cos(k * z_nm);
}

/// Put the image of the rig, which has been changed, into use.
static bool select_anew(fixture_rig_t *rig)
{
    const cam_err_t err =
        cam_machine_select_table(&rig->machine, rig->image.bytes, rig->image.size);
    fixture_rig_tick(rig);
    return err == cam_ok;
}

bool budget_session_way(fixture_rig_t *rig, void (*isr)(void))
{
    enum { n_knots = 15 };
    static const fixture_pass_t passes[] = {{50000, 100000, 1500000, 0}, {0, 100000, 2000000, 0}};
    fixture_part_t part = fixture_part_swung();
    part.speed = fixture_ratio;
    const bool is_open = budget_session_swung(rig, isr, &part);
    fixture_newer_way(&rig->image, half_more, n_knots, 4);
    fixture_newer_passes(&rig->image, passes, 2);
    return is_open && select_anew(rig);
}

bool budget_session_shaft(fixture_rig_t *rig, void (*isr)(void))
{
    fixture_shaft_t shaft = fixture_shaft_three();
    fixture_part_t part = fixture_part_swung();
    shaft.has_speed = true;
    part.speed = fixture_ratio;
    const bool is_open = budget_session_swung(rig, isr, &part);
    fixture_shaft_make(&rig->image, &shaft);
    return is_open && select_anew(rig);
}

bool budget_session_cut(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part)
{
    return budget_session_open(rig, isr, part) && fixture_rig_bring(rig, cam_state_cutting) &&
           fixture_rig_until(rig, cam_state_ready, patience) < patience &&
           rig->last.want.faults == 0u;
}

bool budget_session_force(fixture_rig_t *rig, void (*isr)(void), const fixture_part_t *part)
{
    bool is_good = budget_session_open(rig, isr, part);
    hal_host.slow.force.quantum_un = 20000;
    is_good = is_good && set(rig, cam_param_servo_crossover_hz, 400) &&
              fixture_rig_bring(rig, cam_state_cutting) &&
              fixture_rig_until(rig, cam_state_ready, patience) < patience &&
              rig->last.want.faults == 0u;
    hal_host.slow.force.quantum_un = 0;
    return is_good;
}

bool budget_session_rehearse(fixture_rig_t *rig, void (*isr)(void))
{
    const fixture_part_t part = fixture_part_short();
    return budget_session_open(rig, isr, &part) &&
           fixture_rig_set(rig, cam_param_rehearse_turns, 5) == cam_ok &&
           fixture_rig_bring(rig, cam_state_ready) && cam_machine_start(&rig->machine) == cam_ok &&
           fixture_rig_until(rig, cam_state_rehearsing, 10) < 10u &&
           fixture_rig_until(rig, cam_state_cutting, 100000) < 100000u &&
           fixture_rig_until(rig, cam_state_ready, 60000) < 60000u;
}

bool budget_session_hold(fixture_rig_t *rig, void (*isr)(void))
{
    const fixture_part_t part = fixture_part_short();
    bool is_done =
        budget_session_open(rig, isr, &part) && fixture_rig_bring(rig, cam_state_cutting);
    fixture_rig_ticks(rig, 100);
    is_done = is_done && cam_machine_hold(&rig->machine) == cam_ok &&
              fixture_rig_until(rig, cam_state_holding, 60000) < 60000u;
    fixture_rig_ticks(rig, 1000);
    return is_done && cam_machine_resume(&rig->machine) == cam_ok &&
           fixture_rig_until(rig, cam_state_ready, 100000) < 100000u;
}

enum { n_strikes = 6 };

/// The faults that the host port can cause, by number. `bus` is judged with `drive` by the same
/// instructions.
static void strike(int fault)
{
    switch (fault) {
    case 0:
        hal_host_fault_estop(true);
        break;
    case 1:
        hal_host_fault_drive(true);
        break;
    case 2:
        hal_host_fault_counts(500);
        break;
    case 3:
        hal_host_fault_encoder_stuck(true);
        break;
    case 4:
        hal_host_fault_index_dead(true);
        break;
    default:
        hal_host_fault_late(300);
        break;
    }
}

bool budget_session_faults(fixture_rig_t *rig, void (*isr)(void))
{
    const fixture_part_t part = fixture_part_modulated();
    bool is_done = true;
    for (int fault = 0; fault < n_strikes && is_done; fault++) {
        is_done = budget_session_open(rig, isr, &part) && fixture_rig_bring(rig, cam_state_cutting);
        fixture_rig_ticks(rig, 100);
        strike(fault);
        is_done = is_done && fixture_rig_until(rig, cam_state_fault, 20000) < 20000u;
        fixture_rig_ticks(rig, 2000);
    }
    return is_done;
}

/// A triangle of 32 samples is downloaded. @return whether it is there
static bool load_wave(cam_machine_t *m)
{
    enum { n_samples = 32 };
    int32_t wave_nm[n_samples];
    for (int32_t i = 0; i < n_samples; i++) {
        wave_nm[i] = 100 * (i < n_samples / 2 ? i : n_samples - i);
    }
    const uint8_t *bytes = (const uint8_t *)wave_nm;
    return cam_machine_wave_begin(m, sizeof wave_nm) == cam_ok &&
           cam_machine_wave_block(m, 0, bytes, sizeof wave_nm) == cam_ok &&
           cam_machine_wave_end(m, cam_crc32(0, bytes, sizeof wave_nm)) == cam_ok;
}

bool budget_session_identify(fixture_rig_t *rig, void (*isr)(void))
{
    const fixture_part_t part = fixture_part_short();
    cam_machine_t *m = &rig->machine;
    const bool is_open = budget_session_open(rig, isr, &part);
    hal_host.in.axis_nm[hal_axis_x] = 60000000; // clear of the part
    fixture_rig_tick(rig);
    if (!is_open || !fixture_rig_bring(rig, cam_state_ready) || !load_wave(m) ||
        cam_machine_excite(m, 50, 200).err != cam_ok) {
        return false;
    }
    for (uint32_t i = 0; i < patience && m->identify.phase != cam_identify_none; i++) {
        fixture_rig_tick(rig);
        cam_machine_poll(m);
        cam_machine_keep_alive(m);
    }
    return m->identify.excited == cam_excited_done;
}

/// Home an axis and wait until its home is in force. @return whether it is
static bool home_axis(fixture_rig_t *rig, hal_axis_t axis)
{
    cam_machine_t *m = &rig->machine;
    fixture_rig_tick(rig); // takes the configuration of the last home
    if (cam_machine_home_axis(m, axis) != cam_ok) {
        return false;
    }
    fixture_rig_ticks(rig, 10);
    for (uint32_t i = 0; i < patience && m->offsets.n_found <= (uint32_t)axis; i++) {
        fixture_rig_tick(rig);
        cam_machine_jog_poll(m);
        cam_machine_keep_alive(m);
    }
    return m->offsets.n_found == (uint32_t)axis + 1u;
}

bool budget_session_hand(fixture_rig_t *rig, void (*isr)(void))
{
    const fixture_part_t part = fixture_part_short();
    cam_machine_t *m = &rig->machine;
    bool is_good = budget_session_open(rig, isr, &part);
    rig->lathe.home[hal_axis_u] = (ideal_home_t){.side = 1, .edge_nm = 50000};
    rig->lathe.home[hal_axis_x] =
        (ideal_home_t){.side = 1, .edge_nm = ideal_machine_x_nm + 100000, .pitch_nm = 100000};
    is_good = is_good && set(rig, cam_param_u_home, 2) && set(rig, cam_param_x_home, 3) &&
              set(rig, cam_param_z_home, 1) && cam_machine_manual(m) == cam_ok;
    fixture_rig_ticks(rig, 20);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        is_good = is_good && cam_machine_jog(m, (hal_axis_t)i, 1000).err == cam_ok;
        fixture_rig_ticks(rig, 200);
    }
    is_good = is_good && cam_machine_stop(m) == cam_ok;
    fixture_rig_ticks(rig, 200);
    for (uint32_t i = 0; i < hal_n_axes; i++) {
        is_good = is_good && home_axis(rig, (hal_axis_t)i);
    }
    is_good = is_good && cam_machine_disable(m) == cam_ok;
    fixture_rig_ticks(rig, 500);
    return is_good;
}
