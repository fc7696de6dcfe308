// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <errno.h>  // EBUSY
#include <stdio.h>  // snprintf
#include <stdlib.h> // strtoul
#include <string.h> // strrchr, strerror

static void set_chip(lin_place_t *p, const char *chip, size_t length)
{
    (void)snprintf(p->chip, sizeof p->chip, "%s%.*s", chip[0] == '/' ? "" : "/dev/", (int)length,
                   chip);
}

bool lin_place_parse(lin_place_t *p, const char *chip, const char *place, common_error_t *e)
{
    const char *colon = strrchr(place, ':');
    *p = (lin_place_t){.name = colon == NULL ? place : NULL};
    if (colon == NULL) {
        set_chip(p, chip, strlen(chip));
        return true;
    }
    char *end = NULL;
    const unsigned long offset = strtoul(colon + 1, &end, 10);
    if (colon == place || end == colon + 1 || *end != '\0' || offset > 0xFFFFu) {
        return common_error(e, "%s: no number after the colon; write CHIP:OFFSET or a name", place);
    }
    set_chip(p, place, (size_t)(colon - place));
    p->offset = (unsigned)offset;
    return true;
}

bool lin_place_is_same(const lin_place_t *a, const lin_place_t *b)
{
    const bool is_name = a->name != NULL && b->name != NULL;
    return strcmp(a->chip, b->chip) == 0 &&
           (is_name ? strcmp(a->name, b->name) == 0 : a->name == b->name && a->offset == b->offset);
}

bool lin_place_refuse(const lin_place_t *p, int err, const char *who, common_error_t *e)
{
    char line[lin_name_max + 1];
    if (p->name != NULL) {
        (void)snprintf(line, sizeof line, "%s", p->name);
    } else {
        (void)snprintf(line, sizeof line, "%u", p->offset);
    }
    switch (err) {
    case 0:
        return common_error(e, "%s has no line %s; gpioinfo lists them", p->chip, line);
    case EBUSY:
        return common_error(e,
                            "line %s of %s is in use%s%s; end that program, or choose another line",
                            line, p->chip, who[0] != '\0' ? " by " : "", who);
    case ENOENT:
    case ENODEV:
    case ENOTTY:
        return common_error(e, "%s: no such GPIO chip; gpiodetect lists them", p->chip);
    case EACCES:
    case EPERM:
        return common_error(e, "%s: not permitted; join its group (README.md, \"Without root\")",
                            p->chip);
    default:
        return common_error(e, "line %s of %s: %s", line, p->chip, strerror(err));
    }
}
