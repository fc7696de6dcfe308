// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): strtok_r
#include "camsim.h"
#include "common_number.h" // common_number_parse
#include "sim_identify.h"  // sim_identify_run
#include <stdio.h>         // printf, puts
#include <stdlib.h>        // calloc, free, strtol
#include <string.h>        // strcmp

static const char help[] =
    "camsim identify TABLE --wave F.csv --record F.csv [options]\n"
    "\n"
    "enables the controller, waits until it is ready, plays a wave on U and records it\n"
    "  --wave F.csv          a period: first line u_nm, then a whole number of nanometres per "
    "tick\n"
    "  --record F.csv        tick,t_s and the signals, from the move to the centre until the\n"
    "                        amplitude falls\n"
    "  --periods N           periods at full amplitude (default: 5)\n"
    "  --fade-ticks N        ticks of rise and of fall of the amplitude (default: 2000)\n"
    "  --place-nm N          position of U about which it plays (default: 0)\n"
    "  --signals A,B,..      of cam_scope.h (default: u_set_q6,u_command_nm,u_actual_nm)\n"
    "  --alive-s S           stop keep-alive messages after S, so that the controller aborts\n"
    "\n"
    "as in camsim run: --machine --set --rpm --seed --inject KIND@tSECONDS[:VALUE]\n"
    "\n"
    "Exit status: 0 done, 1 cut short (nothing is written), 2 wrong usage or bad input.";

enum { max_wave_bytes = 16 * 1024 * 1024 };

typedef struct {
    camsim_options_t common;
    sim_identify_options_t identify;
    const char *wave_path, *record_path, *signals;
} identify_options_t;

// Options

static bool take_whole(const char *name, const char *text, double min, double max, double *value,
                       common_error_t *e)
{
    const bool is_good = common_number_parse(text, value) && *value >= min && *value <= max &&
                         *value == (double)(int64_t)*value;
    return is_good ||
           common_error(e, "--%s %.60s: give a whole number %.0f .. %.0f", name, text, min, max);
}

static bool take_value(identify_options_t *o, const char *name, const char *text, common_error_t *e)
{
    double value = 0.0;
    if (strcmp(name, "periods") == 0) {
        const bool is_good = take_whole(name, text, 1.0, 65535.0, &value, e);
        o->identify.n_periods = is_good ? (uint32_t)value : 0u;
        return is_good;
    }
    if (strcmp(name, "fade-ticks") == 0) {
        const bool is_good = take_whole(name, text, 16.0, 65535.0, &value, e);
        o->identify.fade_ticks = is_good ? (uint32_t)value : 0u;
        return is_good;
    }
    if (strcmp(name, "place-nm") == 0) {
        const bool is_good = take_whole(name, text, -15e6, 15e6, &value, e);
        o->identify.place_nm = is_good ? (int32_t)value : 0;
        return is_good;
    }
    if (strcmp(name, "alive-s") == 0) {
        return (common_number_parse(text, &o->identify.alive_s) && o->identify.alive_s > 0.0) ||
               common_error(e, "--alive-s %.60s: give more than 0 seconds", text);
    }
    const char **path = strcmp(name, "wave") == 0     ? &o->wave_path
                        : strcmp(name, "record") == 0 ? &o->record_path
                                                      : &o->signals;
    *path = text;
    return text[0] != '\0' || common_error(e, "--%s: empty; give a value", name);
}

/// Parse an option of this command with its value; the others are options of a run.
/// @return words used; 0: an option of a run; below 0 and *e: wrong usage
static int take_own(identify_options_t *o, int n_left, char **words, common_error_t *e)
{
    static const char *const own[] = {"wave",     "record",  "periods", "fade-ticks",
                                      "place-nm", "signals", "alive-s"};
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++) {
        const size_t length = strlen(own[i]);
        if (strncmp(words[0], "--", 2) != 0 || strncmp(words[0] + 2, own[i], length) != 0) {
            continue;
        }
        const char *rest = words[0] + 2 + length;
        if (rest[0] == '=') {
            return take_value(o, own[i], rest + 1, e) ? 1 : -1;
        }
        if (rest[0] == '\0') {
            if (n_left < 2) {
                (void)common_error(e, "identify: --%s: value missing; see camsim identify --help",
                                   own[i]);
                return -1;
            }
            return take_value(o, own[i], words[1], e) ? 2 : -1;
        }
    }
    return 0;
}

/// @return bits of the named signals, 0 and *e when one is unknown
static uint32_t signals_of(const char *names, common_error_t *e)
{
    uint32_t bits = 0;
    for (const char *at = names; at != NULL;) {
        const char *comma = strchr(at, ',');
        const size_t length = comma != NULL ? (size_t)(comma - at) : strlen(at);
        uint32_t i = 0;
        while (i < cam_scope_n_signals && (strlen(cam_scope_signal_name(i)) != length ||
                                           strncmp(cam_scope_signal_name(i), at, length) != 0)) {
            i++;
        }
        if (i == cam_scope_n_signals) {
            (void)common_error(e, "--signals %.*s: no such signal; see cam_scope.h",
                               (int)(length < 60u ? length : 60u), at);
            return 0;
        }
        bits |= UINT32_C(1) << i;
        at = comma != NULL ? comma + 1 : NULL;
    }
    return bits;
}

static bool check(identify_options_t *o, common_error_t *e)
{
    if (o->common.is_help) {
        return true;
    }
    if (o->wave_path == NULL || o->record_path == NULL) {
        return common_error(e, "identify: --wave and --record are needed; see camsim identify "
                               "--help");
    }
    for (int i = 0; i < camsim_n_outs; i++) {
        if (o->common.out_path[i] != NULL) {
            return common_error(e, "identify: %s: an output of camsim run; leave it out",
                                o->common.out_path[i]);
        }
    }
    if (o->common.cut.target != NULL) {
        return common_error(e, "--target %.60s: identify runs in this process only; leave it out",
                            o->common.cut.target);
    }
    o->common.cut.is_traced = true;
    o->identify.signals = signals_of(o->signals, e);
    return o->identify.signals != 0u;
}

static bool read_options(identify_options_t *o, int argc, char **argv, common_error_t *e)
{
    o->identify = (sim_identify_options_t){.n_periods = 5, .fade_ticks = 2000};
    o->signals = "u_set_q6,u_command_nm,u_actual_nm";
    char **rest = calloc((size_t)argc + 1u, sizeof *rest);
    if (rest == NULL) {
        return common_error(e, "identify: not enough memory; free some");
    }
    int n_rest = 0;
    bool is_good = true;
    for (int i = 0; i < argc && is_good;) {
        const int n = i > 0 ? take_own(o, argc - i, argv + i, e) : 0;
        is_good = n >= 0;
        if (n == 0) {
            rest[n_rest++] = argv[i++];
        }
        i += n > 0 ? n : 0;
    }
    is_good = is_good && camsim_options_read(&o->common, n_rest, rest, e) && check(o, e);
    free(rest);
    return is_good;
}

// The wave

/// @return number of samples in the lines after the first; fewer than lines when *e is set
static bool parse_wave(char *text, const char *path, int32_t *wave_nm, uint32_t *n,
                       common_error_t *e)
{
    char *save = NULL;
    char *line = strtok_r(text, "\n", &save);
    if (line == NULL || strcmp(line, "u_nm") != 0) {
        return common_error(e, "%s: line 1: no u_nm; begin with the column's name", path);
    }
    *n = 0;
    while ((line = strtok_r(NULL, "\n", &save)) != NULL) {
        char *end = NULL;
        const long value = strtol(line, &end, 10);
        if (end == line || *end != '\0' || value < INT32_MIN || value > INT32_MAX) {
            return common_error(e, "%s: line %u: %.40s: give a whole number of nm", path, *n + 2u,
                                line);
        }
        wave_nm[(*n)++] = (int32_t)value;
    }
    return *n > 0u || common_error(e, "%s: no samples; give one in each line after u_nm", path);
}

/// @return samples, which the caller frees; NULL and *e when the file is not a wave
static int32_t *read_wave(const char *path, uint32_t *n, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, max_wave_bytes, e)) {
        return NULL;
    }
    char *text = calloc(file.size + 1u, 1);
    int32_t *wave_nm = calloc(file.size / 2u + 1u, sizeof *wave_nm); // a sample has two characters
    bool is_good = text != NULL && wave_nm != NULL;
    if (is_good) {
        memcpy(text, file.bytes, file.size);
        is_good = parse_wave(text, path, wave_nm, n, e);
    } else {
        (void)common_error(e, "%s: not enough memory for it; free some", path);
    }
    sim_file_free(&file);
    free(text);
    if (!is_good) {
        free(wave_nm);
        wave_nm = NULL;
    }
    return wave_nm;
}

// The recording

static void write_record(sim_out_t *out, const sim_cut_t *cut)
{
    const cam_scope_t *s = &cut->firmware.machine.scope;
    sim_out_text(out, "tick,t_s");
    for (uint32_t i = 0; i < cam_scope_n_signals; i++) {
        if ((s->plan.signals >> i & 1u) != 0u) {
            sim_out_char(out, ',');
            sim_out_text(out, cam_scope_signal_name(i));
        }
    }
    sim_out_char(out, '\n');
    const int32_t *word = &s->words[s->at];
    const uint32_t n_rows = sim_identify_n_played(cut);
    for (uint32_t row = 0; row < n_rows; row++) {
        sim_out_integer(out, (int64_t)s->ring.first_tick + row);
        sim_out_real_column(out, (double)row / s->tick_hz, 9);
        for (uint32_t i = 0; i < s->n_signals; i++) {
            sim_out_integer_column(out, *word++);
        }
        sim_out_char(out, '\n');
    }
}

static int report_short(const sim_cut_t *cut)
{
    static const char *const why[] = {"it never began", "it runs",         "it was played",
                                      "it was stopped", "no sign of life", "a fault"};
    const cam_scope_t *s = &cut->firmware.machine.scope;
    const cam_excited_t end = sim_identify_end(cut);
    if (end == cam_excited_done) {
        (void)fprintf(stderr, "camsim: the recording is incomplete: its memory is full; give fewer "
                              "--signals or --periods\n");
    } else {
        (void)fprintf(stderr,
                      "camsim: the excitation was cut short after %u ticks: %s; nothing "
                      "is written\n",
                      s->ring.n_rows, why[end]);
    }
    return camsim_not_good;
}

static int record(const identify_options_t *o, sim_cut_t *cut, common_error_t *e)
{
    static const char *const option[] = {"--record"};
    static sim_out_t out;
    if (!sim_identify_run(cut, &o->identify, e)) {
        return camsim_complain(e);
    }
    const cam_scope_t *s = &cut->firmware.machine.scope;
    if (sim_identify_end(cut) != cam_excited_done || s->end != cam_scope_state_left) {
        return report_short(cut);
    }
    sim_out_watch_signals();
    if (!sim_out_open_all(&out, &o->record_path, option, 1, e)) {
        return camsim_complain(e);
    }
    write_record(&out, cut);
    const bool is_written = sim_out_publish_all(&out, 1, e);
    sim_out_drop_all(&out, 1);
    if (!is_written) {
        return camsim_complain(e);
    }
    (void)printf("%s: %u rows of %u signals at %u Hz\n", o->record_path, sim_identify_n_played(cut),
                 s->n_signals, s->tick_hz);
    return fflush(stdout) == 0 ? camsim_done : camsim_not_good;
}

static int identify(identify_options_t *o, sim_cut_t *cut, common_error_t *e)
{
    sim_file_t file;
    const char *path = o->common.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, e)) {
        return camsim_complain(e);
    }
    const bool is_open = sim_cut_open(cut, &o->common.cut, file.bytes, file.size, path, e);
    sim_file_free(&file);
    if (!is_open) {
        return camsim_complain(e);
    }
    const int status = record(o, cut, e);
    sim_cut_close(cut);
    return status;
}

int camsim_identify(int argc, char **argv)
{
    static identify_options_t o;
    static sim_cut_t cut; // 16 MB
    common_error_t e;
    if (!read_options(&o, argc, argv, &e)) {
        return camsim_complain(&e);
    }
    if (o.common.is_help) {
        (void)puts(help);
        return camsim_done;
    }
    int32_t *wave_nm = read_wave(o.wave_path, &o.identify.n, &e);
    if (wave_nm == NULL) {
        return camsim_complain(&e);
    }
    o.identify.wave_nm = wave_nm;
    const int status = identify(&o, &cut, &e);
    free(wave_nm);
    return status;
}
