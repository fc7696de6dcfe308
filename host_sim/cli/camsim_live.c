// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "common_number.h" // common_number_parse
#include "sim_file.h"      // sim_file_read
#include "sim_live.h"      // sim_live_open
#include <limits.h>        // INT_MAX
#include <signal.h>        // signal
#include <stdio.h>         // puts
#include <stdlib.h>        // calloc, free
#include <string.h>        // strcmp

static const char help[] =
    "camsim live TABLE --role ROLE --wire FD [options]     one process of tools/live\n"
    "\n"
    "  --role ROLE           controller: CAN frames on stdin and stdout; lathe: faults on stdin\n"
    "  --wire FD             socket (SOCK_SEQPACKET) to the other process\n"
    "  --speed-up F          times faster than the clock, 0.01 .. 100 (default: 1)\n"
    "  --operator WHO        at the machine: present (presses acknowledge when needed and turns\n"
    "                        the key for each commander), absent (neither), waived (no button "
    "needed)\n"
    "                        (default: waived)\n"
    "  --secret FILE         secret that unlocks limits and tables, 16 .. 64 bytes\n"
    "                        (default: none)\n"
    "\n"
    "as in camsim run: --machine --set --rpm --feed --design --seed --inject "
    "KIND@tSECONDS[:VALUE]\n"
    "lathe only: acknowledge:SECONDS (presses the button)  key:1  key:0 (turns the "
    "key)\n"
    "\n"
    "It ends when stdin does. Exit status: 0 done, 2 wrong usage or bad input.";

typedef struct {
    camsim_options_t common;
    sim_live_options_t live;
    const char *role;
} options_t;

static bool take_number(double *value, const char *option, const char *text, double min, double max,
                        common_error_t *e)
{
    return (common_number_parse(text, value) && *value >= min && *value <= max) ||
           common_error(e, "%s %.60s: give a number %.12g .. %.12g", option, text, min, max);
}

static bool take_people(options_t *o, const char *text, common_error_t *e)
{
    static const char *const words[] = {
        [sim_live_waived] = "waived", [sim_live_present] = "present", [sim_live_absent] = "absent"};
    for (uint32_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(text, words[i]) == 0) {
            o->live.people = (sim_live_operator_t)i;
            return true;
        }
    }
    return common_error(e, "--operator %.40s: give present, absent or waived", text);
}

/// Read the secret, without line ends after it.
static bool take_secret(options_t *o, const char *path, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, 1024, e)) {
        return false;
    }
    size_t n = file.size;
    while (n > 0u && (file.bytes[n - 1u] == '\n' || file.bytes[n - 1u] == '\r')) {
        n--;
    }
    const bool is_good = n >= 16u && n <= sizeof o->live.secret;
    if (is_good) {
        memcpy(o->live.secret, file.bytes, n);
        o->live.n_secret = (uint32_t)n;
    }
    sim_file_free(&file);
    return is_good || common_error(e, "--secret %.80s: %zu bytes; give 16 .. 64", path, n);
}

/// Parse an option of this command with its value; the others are options of a run.
/// @return words used; 0: an option of a run; below 0 and *e: wrong usage
static int take_own(options_t *o, int n_left, char **words, common_error_t *e)
{
    double fd = 0.0;
    const bool is_role = strcmp(words[0], "--role") == 0;
    const bool is_wire = strcmp(words[0], "--wire") == 0;
    const bool is_people = strcmp(words[0], "--operator") == 0;
    const bool is_secret = strcmp(words[0], "--secret") == 0;
    if (!is_role && !is_wire && !is_people && !is_secret && strcmp(words[0], "--speed-up") != 0) {
        return 0;
    }
    if (n_left < 2) {
        (void)common_error(e, "live: %s: value missing; see camsim live --help", words[0]);
        return -1;
    }
    if (is_role) {
        o->role = words[1];
    } else if (is_secret) {
        return take_secret(o, words[1], e) ? 2 : -1;
    } else if (is_people) {
        return take_people(o, words[1], e) ? 2 : -1;
    } else if (!is_wire) {
        return take_number(&o->live.speed_up, words[0], words[1], 0.01, 100.0, e) ? 2 : -1;
    } else if (!take_number(&fd, words[0], words[1], 0.0, INT_MAX, e)) {
        return -1;
    } else {
        o->live.wire = (int)fd;
    }
    return 2;
}

static bool check(options_t *o, common_error_t *e)
{
    if (o->common.is_help) {
        return true;
    }
    for (int i = 0; i < camsim_n_outs; i++) {
        if (o->common.out_path[i] != NULL) {
            return common_error(e, "live: %s: an output of camsim run; leave it out",
                                o->common.out_path[i]);
        }
    }
    if (o->common.cut.target != NULL) {
        return common_error(e, "--target %.60s: live runs in this process only; leave it out",
                            o->common.cut.target);
    }
    if (o->role == NULL || (strcmp(o->role, "lathe") != 0 && strcmp(o->role, "controller") != 0)) {
        return common_error(e, "--role %.40s: give lathe or controller",
                            o->role != NULL ? o->role : "(none)");
    }
    if (o->live.wire < 0) {
        return common_error(e, "live: no --wire; let tools/live start both processes");
    }
    o->common.cut.is_traced = true; // the recorder needs it
    o->live.cut = o->common.cut;
    return true;
}

static bool read_options(options_t *o, int argc, char **argv, common_error_t *e)
{
    o->live = (sim_live_options_t){.wire = -1, .speed_up = 1.0};
    char **rest = calloc((size_t)argc + 1u, sizeof *rest);
    if (rest == NULL) {
        return common_error(e, "live: not enough memory; free some");
    }
    int n_rest = 0;
    int taken = 1;
    for (int i = 0; i < argc && taken >= 0; i += taken > 0 ? taken : 1) {
        taken = i > 0 ? take_own(o, argc - i, argv + i, e) : 0;
        if (taken == 0) {
            rest[n_rest++] = argv[i];
        }
    }
    const bool is_good =
        taken >= 0 && camsim_options_read(&o->common, n_rest, rest, e) && check(o, e);
    free(rest);
    return is_good;
}

/// Both processes read the table; each then runs its half.
static int live(const options_t *o, sim_live_t *l, common_error_t *e)
{
    sim_file_t file;
    const char *path = o->common.table_path;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, e)) {
        return camsim_complain(e);
    }
    const bool is_open = sim_live_open(l, &o->live, file.bytes, file.size, path, e);
    sim_file_free(&file);
    if (!is_open) {
        return camsim_complain(e);
    }
    bool is_good = true;
    if (strcmp(o->role, "lathe") == 0) {
        sim_live_lathe(l);
    } else {
        is_good = sim_live_controller(l, e);
    }
    sim_live_close(l);
    return is_good ? camsim_done : camsim_complain(e);
}

int camsim_live(int argc, char **argv)
{
    static options_t o;
    static sim_live_t l; // 16 MB
    common_error_t e;
    if (!read_options(&o, argc, argv, &e)) {
        return camsim_complain(&e);
    }
    if (o.common.is_help) {
        (void)puts(help);
        return camsim_done;
    }
    (void)signal(SIGPIPE, SIG_IGN); // failed writes show that the reader has gone
    return live(&o, &l, &e);
}
