// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): fmemopen
#include "sim_config.h"
#include "common_settings.h" // common_settings_read
#include "sim_file.h"        // sim_file_read
#include <stddef.h>          // offsetof
#include <stdio.h>           // fmemopen, snprintf
#include <string.h>          // strcmp

enum { max_bytes = 1 << 20, least_mode_hz = 10 };

/// A key: where it is stored, kind, default, range, and meaning for machines/default.toml.
#define KEY(kind, section, key, member, normal, min, max, meaning)                                 \
    {                                                                                              \
        section, key, kind, offsetof(sim_lathe_config_t, member), min, max, NULL, normal, meaning  \
    }
#define REAL(...) KEY(common_setting_real, __VA_ARGS__)
#define WHOLE(...) KEY(common_setting_count, __VA_ARGS__)
// clang-format off
#define MODE(key, i, what, of_share) \
    REAL("u", key "_hz", mode[i].hz, 0.0, 0.0, 20000.0, what ", 0: none"), \
    REAL("u", key "_damping", mode[i].damping, 0.03, 0.001, 2.0, ""), \
    REAL("u", key "_share", mode[i].share, 1.0, -2.0, 2.0, of_share), \
    WHOLE("u", key "_on_scale", mode[i].is_on_scale, 0.0, 0.0, 1.0, "0: between scale and tip; 1: the scale measures it")
#define HOME(section, i, what) \
    REAL(section, "home_mm", home[i].switch_mm, 0.0, -2000.0, 2000.0, "place of the home switch's edge" what), \
    REAL(section, "home_side", home[i].side, 0.0, -1.0, 1.0, "1: active from there upwards, -1: downwards, 0: no switch"), \
    REAL(section, "index_pitch_mm", home[i].pitch_mm, 0.0, 0.0, 1000.0, "from index to index, 0: none; one is where the scale counts 0"), \
    REAL(section, "zero_mm", home[i].zero_mm, 0.0, -1000.0, 1000.0, "place where the scale counts 0; homing finds it (firmware/README.md)")
#define DRIVE(section, i, hz, d, us, mm_per_s, mm_per_s2, of_speed) \
    REAL(section, "bandwidth_hz", drive[i].bandwidth_hz, hz, 1.0, 10000.0, "kind \"position\": natural frequency of the closed position loop"), \
    REAL(section, "damping", drive[i].damping, d, 0.05, 10.0, "of that loop"), \
    REAL(section, "delay_us", drive[i].delay_us, us, 0.0, 10000.0, "from the write of a set-point, or of a force, to its effect"), \
    REAL(section, "quantum_nm", drive[i].quantum_micro, 10.0, 0.0, 100000.0, "of set-point and measurement, 0: none"), \
    REAL(section, "command_quantum_nm", drive[i].command_quantum_micro, 0.0, 0.0, 100000.0, "of the set-point alone: the step of a pulse drive, the code of a DAC; 0: quantum_nm"), \
    WHOLE(section, "relative", drive[i].is_relative, 0.0, 0.0, 1.0, "1: an input that counts from its value at enable"), \
    REAL(section, "speed_mm_per_s", drive[i].speed_units_per_s, mm_per_s, 0.1, 10000.0, ""), \
    REAL(section, "acceleration_mm_per_s2", drive[i].acceleration_units_per_s2, mm_per_s2, 10.0, 1e7, of_speed)

static const common_setting_t fields[] = {
    WHOLE("machine", "tick_hz", tick_hz, 20000.0, 500.0, 100000.0, "rate of the controller's tick, 500 .. 100 000"),
    REAL("spindle", "inertia_kgm2", spindle.inertia_kgm2, 0.1, 1e-6, 1e4, "spindle, chuck and part"),
    REAL("spindle", "torque_Nm", spindle.torque_Nm, 50.0, 1e-3, 1e6, "highest torque: 500 rad/s2"),
    REAL("spindle", "bandwidth_rad_per_s", spindle.bandwidth_rad_per_s, 40.0, 0.1, 1000.0, "of the speed loop"),
    REAL("spindle", "ripple", spindle.ripple, 0.002, 0.0, 0.5, "amplitude of the speed ripple, share of the speed"),
    REAL("spindle", "ripple_per_turn", spindle.ripple_per_turn, 2.0, 0.01, 1000.0, "periods of the ripple per turn"),
    REAL("spindle", "ripple_2", spindle.ripple_2, 0.0, 0.0, 0.5, "amplitude of a second ripple"),
    REAL("spindle", "ripple_per_turn_2", spindle.ripple_per_turn_2, 5.0, 0.01, 1000.0, "its periods per turn"),
    REAL("spindle", "runout_um", runout_um, 0.0, 0.0, 1000.0, "run-out once per turn, amplitude: the axis moves against the tool"),
    REAL("spindle", "runout_2_um", runout_2_um, 0.0, 0.0, 1000.0, "run-out twice per turn"),
    REAL("spindle", "start_turn", spindle.start_turn, 0.6, -1000.0, 1000.0, "drawing's angle at the tool at the start"),
    REAL("spindle", "limit_rpm", spindle_limit_rpm, 3000.0, 1.0, 60000.0, "highest speed, r/min"),
    WHOLE("encoder", "counts_per_turn", encoder.counts_per_turn, 10000.0, 64.0, 16777216.0, "four per line, whole"),
    KEY(common_setting_sign, "encoder", "sign", encoder.sign, 1.0, -1.0, 1.0, "-1: counts fall in the machine's positive sense"),
    REAL("encoder", "index_turn", encoder.index_turn, 0.3, 0.0, 1.0, "drawing's angle at the tool at the index"),
    REAL("encoder", "eccentricity_counts", encoder.eccentricity_counts, 0.0, 0.0, 100000.0, "amplitude of the error once per turn"),
    REAL("encoder", "eccentricity_turn", encoder.eccentricity_turn, 0.0, 0.0, 1.0, "angle at which that error is zero and rises"),
    REAL("encoder", "jitter_counts", encoder.jitter_counts, 0.0, 0.0, 1000.0, "rms of the edge noise"),
    WHOLE("encoder", "start_counts", encoder.start_counts, 4294467296.0, 0.0, 4294967295.0, "counter at angle 0: 2^32 - 500 000, so that it wraps during the cut"),
    WHOLE("encoder", "time_stamps", encoder.has_time_stamps, 0.0, 0.0, 1.0, "1: hardware time-stamps the last edge"),
    {"u", "kind", common_setting_choice, offsetof(sim_lathe_config_t, drive[hal_axis_u].kind), 0.0, 0.0, "\"position\" \"force\"", 0.0,
     "a drive that takes positions; \"force\": a mass and an amplifier that takes forces: the controller closes the position loop"},
    DRIVE("u", hal_axis_u, 300.0, 0.7, 75.0, 400.0, 250000.0, "kind \"force\": of its brake while it is disabled"),
    REAL("u", "stroke_mm", u_stroke_mm, 1.2, 0.001, 30.0, "peak to peak, centred on U = 0"),
    HOME("u", hal_axis_u, ""),
    REAL("u", "friction_m_per_s2", drive[hal_axis_u].friction_m_per_s2, 0.0, 0.0, 1000.0, "Coulomb friction divided by the mass"),
    REAL("u", "mass_kg", drive[hal_axis_u].mass_kg, 1.5, 0.01, 1000.0, "pushed by the cutting force and moved by a force drive"),
    REAL("u", "viscous_n_s_per_m", drive[hal_axis_u].viscous_n_s_per_m, 0.0, 0.0, 1e4, "kind \"force\": drag of the guide"),
    REAL("u", "stiffness_n_per_m", drive[hal_axis_u].stiffness_n_per_m, 0.0, 0.0, 1e8, "kind \"force\": spring of the guide"),
    REAL("u", "force_limit_n", drive[hal_axis_u].force_limit_n, 600.0, 0.1, 1e6, "kind \"force\": largest force"),
    REAL("u", "force_quantum_n", drive[hal_axis_u].force_quantum_n, 0.02, 1e-6, 1000.0, "kind \"force\": step of the amplifier's input, here 16 bits"),
    REAL("u", "amplifier_hz", drive[hal_axis_u].amplifier_hz, 2000.0, 10.0, 100000.0, "kind \"force\": corner of the current loop"),
    REAL("u", "stop_mm", drive[hal_axis_u].stop_units, 0.0, 0.0, 100.0, "kind \"force\": stops at either side of U = 0 at this distance, 0: none"),
    REAL("u", "stop_n_per_um", drive[hal_axis_u].stop_n_per_um, 10.0, 0.001, 1000.0, "their stiffness; they damp at half the critical damping"),
    MODE("mode", 0, "a flexible mode", "slow motion moves the tip by -share acceleration / (2 pi mode_hz)^2"),
    MODE("mode_2", 1, "a second one", ""),
    REAL("u", "scale_latency_us", scale.latency_us, 0.0, 0.0, 1000.0, "time by which the scale latches before the encoder"),
    REAL("u", "scale_error_nm", scale.error_nm, 0.0, 0.0, 10000.0, "amplitude of its interpolation error, which has two periods in one period of the scale"),
    REAL("u", "scale_period_um", scale.period_um, 20.0, 0.1, 10000.0, "period of the scale"),
    DRIVE("x", hal_axis_x, 50.0, 1.0, 0.0, 100.0, 2000.0, ""),
    REAL("x", "start_mm", x_start_mm, 2.0, 0.0, 1000.0, "distance from the blank at the start"),
    HOME("x", hal_axis_x, ": a radius"),
    DRIVE("z", hal_axis_z, 50.0, 1.0, 0.0, 200.0, 2000.0, ""),
    REAL("z", "start_mm", z_start_mm, 2.0, -2000.0, 2000.0, "distance before the part's first height at the start"),
    HOME("z", hal_axis_z, ": a height"),
    REAL("swing", "bandwidth_hz", drive[sim_lathe_swing].bandwidth_hz, 200.0, 1.0, 10000.0, ""),
    REAL("swing", "damping", drive[sim_lathe_swing].damping, 0.7, 0.05, 10.0, "makes its lag equal a dead time up to the third derivative"),
    REAL("swing", "delay_us", drive[sim_lathe_swing].delay_us, 100.0, 0.0, 10000.0, ""),
    REAL("swing", "quantum_udeg", drive[sim_lathe_swing].quantum_micro, 100.0, 0.0, 1e6, "of set-point and measurement, 1e-6 degrees, 0: none"),
    REAL("swing", "speed_deg_per_s", drive[sim_lathe_swing].speed_units_per_s, 1000.0, 0.0, 100000.0, "0: the machine has no such axis"),
    REAL("swing", "acceleration_deg_per_s2", drive[sim_lathe_swing].acceleration_units_per_s2, 100000.0, 10.0, 1e8, ""),
    REAL("swing", "range_deg", swing_range_deg, 30.0, 0.1, 90.0, "to either side"),
    REAL("tool", "nose_mm", tool_nose_mm, -1.0, -1.0, 100.0, "radius of its nose, 0: a point, -1: that of the table"),
    REAL("tool", "wear_um", tool_wear_um, 0.0, 0.0, 1000.0, "wear of the tip; the controller's x_trim_nm compensates it"),
    REAL("cut", "kc_n_per_mm2", chip.kc_n_per_mm2, 0.0, 0.0, 100000.0, "specific cutting force, 0: no force"),
    REAL("cut", "radial_share", chip.radial_share, 0.3, 0.0, 10.0, "radial share of the force"),
    REAL("cut", "tool_stiffness_n_per_um", chip.tool_stiffness_n_per_um, 0.0, 0.0, 1e6, "between tip and slide, 0: rigid"),
    WHOLE("chuck", "jaws", chuck.jaws, 3.0, 2.0, 12.0, "at equal distances"),
    REAL("chuck", "jaw_deg", chuck.jaw_deg, 0.0, -360.0, 360.0, "angle of a jaw: the drawing's, without phase"),
    REAL("chuck", "spring_um", chuck.spring_um, 0.0, -1000.0, 1000.0, "by which a cylinder turned at the jaws is out of round when released, peak to valley: metal stands out at the jaws; below 0: jaws that expand inside"),
    REAL("chuck", "jaw_height_mm", chuck.jaw_height_mm, 0.0, -2000.0, 2000.0, "height of the jaws"),
    REAL("chuck", "round_height_mm", chuck.round_height_mm, 0.0, -2000.0, 2000.0, "height where the part stays round, the spring rises linearly from there to the jaws; that of the jaws: alike at all heights"),
    REAL("wheel", "wear_um_per_lobe", wheel_wear_um, 0.0, 0.0, 1000.0, "loss of radius per lobe"),
};
// clang-format on
enum { n_fields = sizeof fields / sizeof fields[0] };
_Static_assert((int)n_fields <= (int)common_settings_max, "one flag for each key");

const char *sim_config_keys(void)
{
    static char text[32768]; // filled once
    static const char *const kinds[] = {[common_setting_real] = "number",
                                        [common_setting_count] = "whole",
                                        [common_setting_sign] = "sign",
                                        [common_setting_choice] = "choice"};
    size_t n = strlen(text);
    for (size_t i = n == 0u ? 0u : n_fields; i < n_fields && n < sizeof text; i++) {
        const common_setting_t *f = &fields[i];
        n +=
            (size_t)snprintf(text + n, sizeof text - n, "%s\t%s\t%s\t%.17g\t%.17g\t%.17g\t%s\t%s\n",
                             f->section, f->key, kinds[f->kind], f->min, f->max, f->normal,
                             f->choices != NULL ? f->choices : "", f->meaning);
    }
    return text;
}

static const char believed_prefix[] = "believed.";
enum { prefix_length = sizeof believed_prefix - 1, section_size = 40 };

/// The keys of [believed.SECTION]: all except those of [machine].
typedef struct {
    char section[n_fields][section_size];
    common_setting_t list[n_fields];
    size_t n;
} belief_keys_t;

static const belief_keys_t *belief_keys(void)
{
    static belief_keys_t keys; // filled once
    for (size_t i = keys.n == 0u ? 0u : n_fields; i < n_fields; i++) {
        if (strcmp(fields[i].section, "machine") == 0) {
            continue;
        }
        char *section = keys.section[keys.n];
        (void)snprintf(section, section_size, "%s%s", believed_prefix, fields[i].section);
        keys.list[keys.n] = fields[i];
        keys.list[keys.n++].section = section;
    }
    return &keys;
}

/// Settings that are not in the list of numbers.
typedef struct {
    sim_config_t *config;
    bool is_name_seen;
    bool has_belief; ///< a key of [believed.SECTION] was seen
} others_t;

sim_config_t sim_config_defaults(void)
{
    sim_config_t config = {.name = "default"};
    for (size_t i = 0; i < n_fields; i++) {
        const bool is_choice = fields[i].kind == common_setting_choice;
        const uint32_t chosen = is_choice ? (uint32_t)fields[i].normal : 0u;
        memcpy((char *)&config.lathe + fields[i].offset,
               is_choice ? (const void *)&chosen : &fields[i].normal,
               is_choice ? sizeof chosen : sizeof fields[i].normal);
    }
    return config;
}

static bool take_parameter(const common_settings_t *s, const char *key, const char *text)
{
    sim_wishes_t *wishes = &((others_t *)s->user)->config->controller;
    double value;
    if (!common_settings_number(text, &value)) {
        return common_settings_refuse(s, "controller", key, text, "not a finite number; give one");
    }
    const cam_param_id_t id = cam_param_find(key);
    if (id < cam_n_params && wishes->is_given[id]) {
        return common_settings_refuse(s, "controller", key, text, "given twice; remove one");
    }
    char origin[300];
    (void)snprintf(origin, sizeof origin, "%.200s: line %d: controller", s->path, s->line);
    return sim_wishes_add(wishes, key, value, origin, s->e);
}

static bool is_belief(const char *section)
{
    return strncmp(section, believed_prefix, prefix_length) == 0;
}

static bool take_other(const common_settings_t *s, const char *section, const char *key,
                       const char *text)
{
    others_t *others = s->user;
    if (is_belief(section)) { // read later, when the truth is known
        others->has_belief = true;
        return true;
    }
    if (strcmp(section, "controller") == 0) {
        return take_parameter(s, key, text);
    }
    if (strcmp(section, "machine") == 0 && strcmp(key, "name") == 0) {
        char *name = others->config->name;
        if (others->is_name_seen ||
            !common_settings_text(text, name, sizeof others->config->name - 1u)) {
            return common_settings_refuse(s, section, key, text,
                                          "give one \"text\" of at most 63 characters, once");
        }
        others->is_name_seen = true;
        return true;
    }
    return common_settings_refuse_key(s, section, key,
                                      "unknown; see host_sim/machines/default.toml for all keys");
}

/// Refuse an unknown key of [believed.SECTION]; skip the keys already read.
static bool refuse_belief(const common_settings_t *s, const char *section, const char *key,
                          const char *text)
{
    return !is_belief(section) ||
           common_settings_refuse(s, section, key, text,
                                  "not allowed here; give a key of another section "
                                  "than [machine] of host_sim/machines/default.toml");
}

/// Read a text once, without changing it.
static bool read_once(common_settings_t *all, const char *text, size_t size)
{
    if (size == 0u) { // fmemopen() may refuse an empty text
        return true;
    }
    FILE *stream = fmemopen((void *)text, size, "r");
    if (stream == NULL) {
        return common_error(all->e, "%s: not enough memory; free some", all->path);
    }
    const bool is_good = common_settings_read(all, stream);
    (void)fclose(stream);
    return is_good;
}

/// Read a text a second time, for the believed values.
static bool read_belief(common_settings_t *all, sim_config_t *config, const char *text, size_t size)
{
    if (!config->has_belief) {
        config->believed = config->lathe;
    }
    config->has_belief = true;
    all->list = belief_keys()->list;
    all->n = belief_keys()->n;
    all->into = &config->believed;
    all->take_other = refuse_belief;
    return read_once(all, text, size);
}

/// Refuse modes too slow for the cubics of sim_lathe.h.
static bool check_modes(const sim_lathe_config_t *lathe, const char *name, common_error_t *e)
{
    for (int i = 0; i < sim_mode_n; i++) {
        const double hz = lathe->mode[i].hz;
        if (hz > 0.0 && hz < least_mode_hz) {
            return common_error(
                e, "%s: u.mode_%shz = %.12g: too slow; give 0 for none, or %d .. 20000", name,
                i > 0 ? "2_" : "", hz, (int)least_mode_hz);
        }
    }
    return true;
}

bool sim_config_read(sim_config_t *config, const char *text, size_t size, const char *name,
                     common_error_t *e)
{
    others_t others = {.config = config};
    common_settings_t all = {.path = name,
                             .list = fields,
                             .n = n_fields,
                             .into = &config->lathe,
                             .take_other = take_other,
                             .user = &others,
                             .has_line_word = true,
                             .value_width = 60,
                             .e = e};
    if (!read_once(&all, text, size) ||
        (others.has_belief && !read_belief(&all, config, text, size)) ||
        !check_modes(&config->lathe, name, e)) {
        return false;
    }
    return true;
}

bool sim_config_load(sim_config_t *config, const char *path, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, max_bytes, e)) {
        return false;
    }
    const bool is_good = sim_config_read(config, (const char *)file.bytes, file.size, path, e);
    sim_file_free(&file);
    return is_good;
}
