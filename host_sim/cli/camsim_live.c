// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "sim_file.h" // sim_file_read
#include "sim_live.h" // sim_live_open
#include <limits.h>   // INT_MAX
#include <signal.h>   // signal
#include <string.h>   // strcmp

typedef struct {
    camsim_options_t common;
    sim_live_options_t live;
    const char *role;
    double wire; ///< as given; live holds it, too
} options_t;

#define AT(member) offsetof(options_t, member)

static bool take_people(void *options, const char *text, common_error_t *e)
{
    options_t *o = options;
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

static const camsim_option_t own[] = {
    CAMSIM_TEXT("role", "ROLE", AT(role),
                "controller: CAN frames on stdin and stdout; lathe: faults on stdin"),
    CAMSIM_WHOLE("wire", "FD", AT(wire), 0.0, INT_MAX,
                 "socket (SOCK_SEQPACKET) to the other process"),
    CAMSIM_NUMBER("speed-up", "F", AT(live.speed_up), 0.01, 100.0, "a pure number",
                  "times faster than the clock, 0.01 .. 100 (default: 1)"),
    CAMSIM_TAKEN("operator", "WHO", take_people,
                 "at the machine: present (presses acknowledge when needed and turns the key for "
                 "each commander), absent (neither), waived (no button needed) (default: waived)"),
};

static const char help[] =
    "One process of tools/live.\v"
    "As in camsim run: --machine --set --rpm --feed --design --seed\n"
    "--inject KIND@tSECONDS[:VALUE]; lathe only: acknowledge:SECONDS (presses the\n"
    "button)  key:1  key:0 (turns the key)\n"
    "\n"
    "It ends when stdin does. Exit status: 0 done, 2 wrong usage or bad input.";

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
    if (o->role == NULL || (strcmp(o->role, "lathe") != 0 && strcmp(o->role, "controller") != 0)) {
        return common_error(e, "--role %.40s: give lathe or controller",
                            o->role != NULL ? o->role : "(none)");
    }
    if (o->wire < 0.0) {
        return common_error(e, "live: no --wire; let tools/live start both processes");
    }
    o->live.wire = (int)o->wire;
    o->live.cut = o->common.cut;
    return true;
}

static bool read_options(options_t *o, int argc, char **argv, common_error_t *e)
{
    const camsim_set_t set = {own, sizeof own / sizeof own[0], o};
    o->live.speed_up = 1.0;
    o->wire = -1.0;
    return camsim_options_read_with(&o->common, set, argc, argv, e) && check(o, e);
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
        const camsim_set_t set = {own, sizeof own / sizeof own[0], NULL};
        camsim_help("camsim live", "TABLE --role ROLE --wire FD", help, set);
        return camsim_done;
    }
    camsim_warn_of_retired(&o.common);
    (void)signal(SIGPIPE, SIG_IGN); // failed writes show that the reader has gone
    return live(&o, &l, &e);
}
