// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "sim_cut_pass.h" // sim_cut_planned_s
#include <stdio.h>        // printf

static const char help[] =
    "Prints the controller's configuration as lines of name,value: tick_hz, then the length of the "
    "cut (planned_turns of cutting and planned_s of machine time, passes, rehearsal, engaging and "
    "disengaging included), then the parameters of firmware/param/cam_param.h.\v"
    "As in camsim run: --machine --set --rpm --feed\n"
    "\n"
    "Exit status: 0 done, 2 wrong usage or bad input.";

static bool check(const camsim_options_t *o, common_error_t *e)
{
    for (int i = 0; i < camsim_n_outs; i++) {
        if (o->out_path[i] != NULL) {
            return common_error(e, "params: %s: an output of camsim run; leave it out",
                                o->out_path[i]);
        }
    }
    return true;
}

static int print(sim_cut_t *cut)
{
    (void)printf("name,value\ntick_hz,%.0f\n", cut->session.options.config.lathe.tick_hz);
    (void)printf("planned_turns,%.6g\nplanned_s,%.6g\n", sim_cut_planned_in_all(cut),
                 sim_cut_planned_s(cut));
    for (int i = 0; i < cam_n_params; i++) {
        const cam_param_id_t id = (cam_param_id_t)i;
        (void)printf("%s,%d\n", cam_param_info(id)->name,
                     (int)cam_param_get(&cut->firmware.machine.params, id));
    }
    return fflush(stdout) == 0 ? camsim_done : camsim_not_good;
}

int camsim_params(int argc, char **argv)
{
    static camsim_options_t o;
    static sim_cut_t cut; // 16 MB
    common_error_t e;
    if (!camsim_options_read(&o, argc, argv, &e) || (!o.is_help && !check(&o, &e))) {
        return camsim_complain(&e);
    }
    if (o.is_help) {
        camsim_help("camsim params", "TABLE", help, (camsim_set_t){.n = 0});
        return camsim_done;
    }
    camsim_warn_of_retired(&o);
    if (!camsim_open_cut(&o, &cut, &e)) {
        return camsim_complain(&e);
    }
    const int status = print(&cut);
    sim_cut_close(&cut);
    return status;
}
