// SPDX-License-Identifier: Apache-2.0
#define _POSIX_C_SOURCE 200809L // NOLINT(bugprone-reserved-identifier): getline
#include "camsim.h"
#include "cam_eval.h"      // cam_eval_surface_at, cam_lobes_find, cam_speed_ratio_at
#include "cam_plan.h"      // cam_shaft_share
#include "common_number.h" // common_number_parse
#include "sim_units.h"     // sim_clamp
#include <errno.h>         // errno
#include <math.h>          // floor, ldexp
#include <stdio.h>         // printf
#include <stdlib.h>        // free
#include <string.h>        // strlen, strerror

static const char help[] =
    "camsim eval TABLE < points.csv > values.csv\n"
    "\n"
    "in:  turn,z_mm   turn: drawing's angle / one turn, any number, 0 = long axis; the same\n"
    "                 sense for tables of M3 and of M4;\n"
    "                 z_mm: skirt height of the drawing, rounded to 1 nm\n"
    "out: turn,z_mm,u_nm,u1_nm_per_rad,u2_nm_per_rad2,x_nm,speed_ratio,clamped\n"
    "     u: radius reduction, with its derivatives by the drawing's angle; x: long half axis;\n"
    "     tip radius = x - u;\n"
    "     speed_ratio: spindle speed / mean speed; clamped: 1 where z is outside the table\n"
    "a cam adds two columns, swing_deg,contact_deg:\n"
    "     u: lift, away from the axis, of the roller's centre (turning) or of the wheel's "
    "(grinding);\n"
    "     x: their distance from the axis on the base circle; swing: of the tool, 0 when "
    "grinding;\n"
    "     contact: angle from the line of centres to the normal at the contact";

static const char header_in[] = "turn,z_mm";
static const char header_out[] =
    "turn,z_mm,u_nm,u1_nm_per_rad,u2_nm_per_rad2,x_nm,speed_ratio,clamped";
static const char header_lobes[] = ",swing_deg,contact_deg";

/// Table angles rise in the sense of cutting: for M4 the table mirrors the drawing.
static double sense_of(const cam_table_t *t)
{
    return t->direction;
}

static bool has_lobes(const cam_table_t *t)
{
    return t->angle.knots != NULL;
}

/// @return the angle within the turn, rounded to 2^-32; huge values count as whole turns
static uint32_t angle_q32(double turn)
{
    const double part = turn - floor(turn);
    return (uint32_t)(uint64_t)(part * 4294967296.0 + 0.5); // 2^32 wraps to 0 by design
}

/// Position of a point in the channels over angle: those of a shaft play the pattern of a lobe,
/// with reduced lift and speed ratio between two lobes.
typedef struct {
    uint32_t theta_q32;
    int32_t z_nm;
    const cam_lobe_t *lobe; ///< NULL: slices are heights
    double lift, ratio;     ///< shares of both
} place_t;

static place_t place_of(const cam_table_t *t, double turn, int32_t z_nm)
{
    place_t at = {.theta_q32 = angle_q32(turn), .z_nm = z_nm, .lift = 1.0, .ratio = 1.0};
    if (t->n_lobes > 0u) {
        const uint32_t i = cam_lobes_find(t, z_nm);
        const cam_share_t share =
            cam_shaft_share(cam_lobes_change_q31(t, i, z_nm), t->speed.knots != NULL);
        at.lobe = &t->lobes[i];
        at.theta_q32 -= at.lobe->phase_q32;
        at.lift = ldexp(share.lift_q30, -30);
        at.ratio = ldexp(share.ratio_q30, -30);
    }
    return at;
}

static cam_height_t slice_of(const cam_channel_t *ch, const place_t *at)
{
    return at->lobe != NULL ? cam_lobes_slice(ch->n_slices, at->lobe->pattern)
                            : cam_eval_height(ch, at->z_nm);
}

static cam_value_t value_of(const cam_channel_t *ch, const place_t *at)
{
    return cam_eval_surface_at(ch, at->theta_q32, slice_of(ch, at));
}

static double speed_ratio(const cam_table_t *t, const place_t *at)
{
    if (t->speed.knots == NULL) {
        return 1.0;
    }
    const cam_ratio_t ratio = cam_speed_ratio_at(&t->speed, at->theta_q32, slice_of(&t->speed, at));
    return 1.0 + at->ratio * (ldexp(ratio.ratio_q28, -28) - 1.0);
}

/// @return whether a height is outside a channel, which is then evaluated at its edge
static bool is_beyond(const cam_channel_t *ch, int32_t z_nm)
{
    return z_nm < ch->z_first_nm || z_nm - (int64_t)ch->z_first_nm > (int64_t)ch->span_nm;
}

static bool print_value(const cam_table_t *t, const char *point, double turn, double z_mm)
{
    const int32_t z_nm =
        (int32_t)floor(sim_clamp(z_mm * SIM_NM_PER_MM, INT32_MIN, INT32_MAX) + 0.5);
    const place_t at = place_of(t, sense_of(t) * turn, z_nm);
    const cam_value_t u = value_of(&t->u, &at);
    const cam_value_t x = cam_eval_profile(&t->x, z_nm);
    const double ratio = speed_ratio(t, &at);
    const double h = ldexp(SIM_TWO_PI, -(int)(t->u.log2_knots + t->u.log2_repeat));
    const int frac = -(int)t->u.frac_bits;
    const bool is_outside = z_mm * SIM_NM_PER_MM < (double)t->z_first_nm - 0.5 ||
                            z_mm * SIM_NM_PER_MM > (double)t->z_last_nm + 0.5 ||
                            (!has_lobes(t) && is_beyond(&t->u, z_nm)) || is_beyond(&t->x, z_nm);
    const double sense = has_lobes(t) ? -at.lift : 1.0; // a lift is a negative reduction
    if (printf("%s,%.17g,%.17g,%.17g,%.17g,%.17g,%d", point,
               0.0 + sense * (t->u.value_offset + ldexp(u.y, frac)),
               0.0 + sense * sense_of(t) * ldexp(u.d1, frac) / h,
               0.0 + sense * ldexp(u.d2, frac) / (h * h), // + 0: no "-0"
               t->x.value_offset + ldexp(x.y, -(int)t->x.frac_bits), ratio,
               is_outside ? 1 : 0) <= 0) {
        return false;
    }
    if (!has_lobes(t)) {
        return putchar('\n') != EOF;
    }
    // Angle between the line of centres and the normal at the contact; CAM_TABLE_ANGLE_MAX units
    // are a quarter turn.
    const cam_value_t angle = value_of(&t->angle, &at);
    const double units =
        at.lift * (t->angle.value_offset + ldexp(angle.y, -(int)t->angle.frac_bits));
    const double deg = ldexp(units * 90.0, -24);
    return printf(",%.17g,%.17g\n", t->is_swung ? deg : 0.0, deg) > 0;
}

/// Parse "turn,z_mm"; the line itself is kept for the echo.
static bool parse_point(const char *line, double *turn, double *z_mm)
{
    char copy[256];
    if (strlen(line) >= sizeof copy) {
        return false;
    }
    memcpy(copy, line, strlen(line) + 1u);
    char *comma = strchr(copy, ',');
    if (comma == NULL) {
        return false;
    }
    *comma = '\0';
    return common_number_parse(copy, turn) && common_number_parse(comma + 1, z_mm);
}

static bool take_line(const cam_table_t *t, const char *line, size_t i_line, common_error_t *e)
{
    if (i_line == 1u) {
        return strcmp(line, header_in) == 0
                   ? printf("%s%s\n", header_out, has_lobes(t) ? header_lobes : "") > 0
                   : common_error(e,
                                  "standard input: line 1: \"%.60s\": wrong header; write \"%s\"",
                                  line, header_in);
    }
    double turn;
    double z_mm;
    if (!parse_point(line, &turn, &z_mm)) {
        return common_error(
            e, "standard input: line %zu: \"%.60s\": not two finite numbers; write turn,z_mm",
            i_line, line);
    }
    return print_value(t, line, turn, z_mm) ||
           common_error(e,
                        "standard output: cannot be written: %s; make room or give another target",
                        strerror(errno));
}

static bool take_lines(const cam_table_t *t, common_error_t *e)
{
    char *line = NULL;
    size_t capacity = 0;
    size_t i_line = 0;
    bool is_good = true;
    ssize_t length;
    while (is_good && (length = getline(&line, &capacity, stdin)) >= 0) {
        i_line++;
        if (strlen(line) != (size_t)length) {
            is_good =
                common_error(e, "standard input: line %zu: holds a zero byte; give text", i_line);
            break;
        }
        while (length > 0 && (line[length - 1] == '\n' || line[length - 1] == '\r')) {
            line[--length] = '\0';
        }
        is_good = take_line(t, line, i_line, e);
    }
    free(line);
    if (is_good && ferror(stdin) != 0) {
        return common_error(e, "standard input: cannot be read: %s; give a CSV file",
                            strerror(errno));
    }
    if (is_good && i_line == 0u) {
        return common_error(e, "standard input: empty; give \"%s\" and points", header_in);
    }
    return is_good;
}

static bool eval(const char *path, common_error_t *e)
{
    sim_file_t file;
    if (!sim_file_read(&file, path, camsim_max_table_bytes, e)) {
        return false;
    }
    cam_table_t table;
    const cam_err_t err = cam_table_check(file.bytes, file.size, &table);
    bool is_good =
        err == cam_ok || common_error(e, "%s: table refused: %s; make it again with tools/mktables",
                                      path, cam_err_text(err));
    is_good = is_good && take_lines(&table, e);
    sim_file_free(&file);
    if (is_good && (fflush(stdout) != 0 || ferror(stdout) != 0)) {
        return common_error(
            e, "standard output: cannot be written: %s; make room or give another target",
            strerror(errno));
    }
    return is_good;
}

int camsim_eval(int argc, char **argv)
{
    common_error_t e;
    if (argc == 2 && (strcmp(argv[1], "--help") == 0 || strcmp(argv[1], "-h") == 0)) {
        return puts(help) >= 0 && fflush(stdout) == 0 ? camsim_done : camsim_wrong;
    }
    if (argc != 2 || argv[1][0] == '-') {
        (void)common_error(&e,
                           "eval: give one TABLE and points on standard input; camsim eval --help");
        return camsim_complain(&e);
    }
    return eval(argv[1], &e) ? camsim_done : camsim_complain(&e);
}
