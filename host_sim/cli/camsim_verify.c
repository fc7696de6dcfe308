// SPDX-License-Identifier: Apache-2.0
#include "camsim.h"
#include "cam_signature_check.h" // cam_signature_check_table
#include "common_keys.h"         // common_keys_add
#include "hal_host.h"            // hal_host
#include <stdio.h>               // printf, puts
#include <string.h>              // strcmp

static const char help[] =
    "camsim verify TABLE [KEY.pub ...]\n"
    "\n"
    "  Judges a table like a controller that requires a signature by one of these keys, or, "
    "without\n"
    "  keys, like one that requires none.\n"
    "\n"
    "Exit status: 0 accepted, 1 refused, 2 wrong usage or bad input.";

static bool add_keys(common_keys_t *keys, const char *path, common_error_t *e)
{
    enum { most_bytes = 4096 };
    sim_file_t file;
    char text[most_bytes + 1] = "";
    if (!sim_file_read(&file, path, most_bytes, e)) {
        return false;
    }
    memcpy(text, file.bytes, file.size);
    sim_file_free(&file);
    return common_keys_add(keys, text) ||
           common_error(e, "%s: not a public key; " COMMON_KEYS_REMEDY, path);
}

static int verify(const char *path)
{
    common_error_t e;
    sim_file_t file;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, &e)) {
        return camsim_complain(&e);
    }
    cam_table_t table;
    cam_signature_check_t verdict;
    const cam_err_t err = cam_signature_check_table(file.bytes, file.size, &table, &verdict);
    static const char *const kinds[] = {"not signed", "signature not checked", "signed"};
    (void)printf("%s: %s\n", path, err == cam_ok ? kinds[verdict.kind] : cam_err_text(err));
    sim_file_free(&file);
    return err == cam_ok ? camsim_done : camsim_not_good;
}

int camsim_verify(int argc, char **argv)
{
    static common_keys_t keys;
    common_error_t e;
    if (argc == 2 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)) {
        return puts(help) >= 0 && fflush(stdout) == 0 ? camsim_done : camsim_wrong;
    }
    if (argc < 2 || argv[1][0] == '-') {
        (void)common_error(&e, "verify: give a TABLE and public keys; camsim verify --help");
        return camsim_complain(&e);
    }
    for (int i = 2; i < argc; i++) {
        if (!add_keys(&keys, argv[i], &e)) {
            return camsim_complain(&e);
        }
    }
    hal_host.slow.trust =
        (hal_trust_t){.keys = keys.bytes, .n_keys = keys.n, .is_required = keys.n > 0u};
    return verify(argv[1]);
}
