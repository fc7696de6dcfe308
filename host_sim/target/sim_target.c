// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE // NOLINT(bugprone-reserved-identifier): readlink
#include "sim_target.h"
#include <errno.h>  // errno
#include <stdio.h>  // snprintf
#include <string.h> // strcmp, strerror, strrchr
#include <unistd.h> // access, readlink

static const sim_target_t targets[] = {
    {"mps2-an500", "mcu-qemu"},
    {"mps2-an386", "mcu-qemu-m4"},
};

const sim_target_t *sim_target_find(const char *name, common_error_t *e)
{
    for (size_t i = 0; i < sizeof targets / sizeof targets[0]; i++) {
        if (strcmp(targets[i].name, name) == 0) {
            return &targets[i];
        }
    }
    (void)common_error(e, "--target %.60s: no such target; use %s or %s", name, targets[0].name,
                       targets[1].name);
    return NULL;
}

bool sim_target_check_image(const sim_target_t *target, const char *image, common_error_t *e)
{
    return access(image, R_OK) == 0 ||
           common_error(e, "--target %s: %.300s: %s; build it by: cmake --workflow --preset %s",
                        target->name, image, strerror(errno), target->preset);
}

bool sim_target_image(const sim_target_t *target, char *path, size_t size, common_error_t *e)
{
    char self[4096];
    const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1u);
    self[length > 0 ? length : 0] = '\0';
    for (int i = 0; i < 3; i++) { // BUILD/PRESET/host_sim/camsim
        char *slash = strrchr(self, '/');
        if (slash == NULL) {
            return common_error(
                e, "--target %s: no build folder around camsim; give --target-image", target->name);
        }
        *slash = '\0';
    }
    const int n = snprintf(path, size, "%s/%s/pil/pil.elf", self, target->preset);
    return (n > 0 && (size_t)n < size) ||
           common_error(e, "--target %s: path too long; give --target-image", target->name);
}
