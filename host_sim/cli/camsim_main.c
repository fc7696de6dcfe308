// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "hal/version.h" // CAMTURN_VERSION
#include <stdio.h>       // puts
#include <string.h>      // strcmp

static const char help[] =
    "camsim: the camturn controller on a simulated lathe\n"
    "\n"
    "  camsim eval TABLE < points.csv > values.csv   the firmware's own evaluation of a table\n"
    "  camsim run TABLE [options]                    a whole cut in virtual time\n"
    "  camsim bus TABLE --can IFACE [options]        the machine as nodes of a CAN bus\n"
    "  camsim identify TABLE --wave F --record F     U plays a wave and is recorded\n"
    "  camsim live TABLE --role R --wire FD          one of the two processes of tools/live\n"
    "  camsim params TABLE [options]                 what the controller is configured with\n"
    "  camsim eval --help | run --help | bus --help | identify --help | live --help |\n"
    "  camsim params --help | --version\n"
    "\n"
    "TABLE is a NAME.camtab made by tools/mktables.\n"
    "Exit status: 0 done, 1 fault or out of tolerance, 2 wrong usage or bad input.";

int camsim_complain(const common_error_t *e)
{
    (void)fprintf(stderr, "camsim: %s\n", e->text);
    return camsim_wrong;
}

/// @return exit status; a failed print is an error
static int after_print(void)
{
    common_error_t e;
    if (fflush(stdout) != 0 || ferror(stdout) != 0) {
        (void)common_error(&e,
                           "standard output: cannot be written; make room or give another target");
        return camsim_complain(&e);
    }
    return camsim_done;
}

static const struct {
    const char *name;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"eval", camsim_eval},         {"run", camsim_run},   {"bus", camsim_bus},
    {"identify", camsim_identify}, {"live", camsim_live}, {"params", camsim_params},
};

int main(int argc, char **argv)
{
    const char *command = argc > 1 ? argv[1] : "";
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        if (strcmp(command, commands[i].name) == 0) {
            return commands[i].run(argc - 1, argv + 1);
        }
    }
    if (strcmp(command, "--help") == 0 || strcmp(command, "-h") == 0) {
        (void)puts(help);
        return after_print();
    }
    if (strcmp(command, "--version") == 0) {
        (void)puts("camsim " CAMTURN_VERSION);
        return after_print();
    }
    common_error_t e;
    (void)common_error(&e,
                       "%.40s: no such command; use eval, run, bus, identify, live or "
                       "params; see camsim --help",
                       argc > 1 ? command : "(nothing)");
    return camsim_complain(&e);
}
