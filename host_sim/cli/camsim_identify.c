// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): strtok_r
#include "camsim.h"
#include "sim_identify.h" // sim_identify_run
#include <stdio.h>        // printf
#include <stdlib.h>       // calloc, free, strtol
#include <string.h>       // strcmp

enum { max_wave_bytes = 16 * 1024 * 1024 };

typedef struct {
    camsim_options_t common;
    sim_identify_options_t identify;
    const char *wave_path, *record_path, *signals;
    double n_periods, fade_ticks, place_nm; ///< as given; identify holds them, too
} identify_options_t;

// Options

#define AT(member) offsetof(identify_options_t, member)

static const camsim_option_t own[] = {
    CAMSIM_TEXT(
        "wave", "F.csv", AT(wave_path),
        "a period: first line u_nm, then a whole number of nanometres per tick; or force_mn "
        "and millinewtons of force"),
    CAMSIM_TEXT("record", "F.csv", AT(record_path),
                "tick,t_s and the signals, from the move to the centre until the amplitude falls"),
    CAMSIM_WHOLE("periods", "N", AT(n_periods), 1.0, 65535.0,
                 "periods at full amplitude (default: 5)"),
    CAMSIM_WHOLE("fade-ticks", "N", AT(fade_ticks), 16.0, 65535.0,
                 "ticks of rise and of fall of the amplitude (default: 2000)"),
    CAMSIM_WHOLE("place-nm", "N", AT(place_nm), -15e6, 15e6,
                 "position of U about which it plays (default: 0)"),
    CAMSIM_TEXT("signals", "A,B,..", AT(signals),
                "of cam_recorder.h (default: u_set_q6,u_command_nm,u_actual_nm)"),
    CAMSIM_NUMBER("alive-s", "S", AT(identify.alive_s), 1e-6, 1e9, "seconds",
                  "stop keep-alive messages after S, so that the controller aborts"),
};

static const char help[] =
    "Enables the controller, waits until it is ready, plays a wave on U and records it.\v"
    "As in camsim run: --machine --set --rpm --seed --inject KIND@tSECONDS[:VALUE]\n"
    "\n"
    "Exit status: 0 done, 1 cut short (nothing is written), 2 wrong usage or bad input.";

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
            (void)common_error(e, "--signals %.*s: no such signal; see cam_recorder.h",
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
    o->identify.n_periods = (uint32_t)o->n_periods;
    o->identify.fade_ticks = (uint32_t)o->fade_ticks;
    o->identify.place_nm = (int32_t)o->place_nm;
    o->identify.signals = signals_of(o->signals, e);
    return o->identify.signals != 0u;
}

static bool read_options(identify_options_t *o, int argc, char **argv, common_error_t *e)
{
    const camsim_set_t set = {own, sizeof own / sizeof own[0], o};
    o->n_periods = 5.0;
    o->fade_ticks = 2000.0;
    o->signals = "u_set_q6,u_command_nm,u_actual_nm";
    return camsim_options_read_with(&o->common, set, argc, argv, e) && check(o, e);
}

// The wave

/// @return number of samples in the lines after the first; fewer than lines when *e is set
static bool parse_wave(char *text, const char *path, int32_t *wave, sim_identify_options_t *o,
                       common_error_t *e)
{
    char *save = NULL;
    char *line = strtok_r(text, "\n", &save);
    o->is_force = line != NULL && strcmp(line, "force_mn") == 0;
    if (!o->is_force && (line == NULL || strcmp(line, "u_nm") != 0)) {
        return common_error(e, "%s: line 1: no u_nm or force_mn; begin with the column's name",
                            path);
    }
    const char *unit = o->is_force ? "mN" : "nm";
    uint32_t *n = &o->n;
    *n = 0;
    while ((line = strtok_r(NULL, "\n", &save)) != NULL) {
        char *end = NULL;
        const long value = strtol(line, &end, 10);
        if (end == line || *end != '\0' || value < INT32_MIN || value > INT32_MAX) {
            return common_error(e, "%s: line %u: %.40s: give a whole number of %s", path, *n + 2u,
                                line, unit);
        }
        wave[(*n)++] = (int32_t)value;
    }
    return *n > 0u || common_error(e, "%s: no samples; give one in each line after the name", path);
}

/// @return samples, which the caller frees; NULL and *e when the file is not a wave
static int32_t *read_wave(const char *path, sim_identify_options_t *o, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, max_wave_bytes, e)) {
        return NULL;
    }
    char *text = calloc(file.size + 1u, 1);
    int32_t *wave = calloc(file.size / 2u + 1u, sizeof *wave); // a sample has two characters
    bool is_good = text != NULL && wave != NULL;
    if (is_good) {
        memcpy(text, file.bytes, file.size);
        is_good = parse_wave(text, path, wave, o, e);
    } else {
        (void)common_error(e, "%s: not enough memory for it; free some", path);
    }
    sim_file_free(&file);
    free(text);
    if (!is_good) {
        free(wave);
        wave = NULL;
    }
    return wave;
}

// The recording

static void write_record(sim_out_t *out, const sim_cut_t *cut)
{
    static char columns[sim_rows_max_columns * 40]; // sim_rows_open keeps them
    static sim_rows_t rows;
    const cam_scope_t *s = &cut->firmware.machine.scope;
    size_t n = (size_t)snprintf(columns, sizeof columns, "tick:0,t_s:9");
    for (uint32_t i = 0; i < cam_scope_n_signals; i++) {
        if ((s->plan.signals >> i & 1u) != 0u) {
            n += (size_t)snprintf(columns + n, sizeof columns - n, ",%s:0",
                                  cam_scope_signal_name(i));
        }
    }
    sim_rows_open(&rows, columns);
    sim_out_header(out, &rows);
    const int32_t *word = &s->words[s->at];
    const uint32_t n_rows = sim_identify_n_played(cut);
    for (uint32_t row = 0; row < n_rows; row++) {
        sim_rows_add(&rows, (int64_t)s->ring.first_tick + row);
        sim_rows_real(&rows, (double)row / s->tick_hz);
        for (uint32_t i = 0; i < s->n_signals; i++) {
            sim_rows_add(&rows, *word++);
        }
        sim_out_rows(out, &rows);
    }
    sim_rows_free(&rows);
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
    if (!camsim_open_cut(&o->common, cut, e)) {
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
        const camsim_set_t set = {own, sizeof own / sizeof own[0], NULL};
        camsim_help("camsim identify", "TABLE --wave F.csv --record F.csv", help, set);
        return camsim_done;
    }
    camsim_warn_of_retired(&o.common);
    int32_t *wave = read_wave(o.wave_path, &o.identify, &e);
    if (wave == NULL) {
        return camsim_complain(&e);
    }
    o.identify.wave = wave;
    const int status = identify(&o, &cut, &e);
    free(wave);
    return status;
}
