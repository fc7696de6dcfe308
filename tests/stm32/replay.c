// SPDX-License-Identifier: Apache-2.0
/// replay: the controller on the host, fed with what the controller in the image sensed.
///
///     stm32_replay image FILE        write the table image of a short part
///     stm32_replay TICK_HZ CLOCK_HZ X_MOST Z_MOST
///                                    read lines, write a line per tick; X_MOST and Z_MOST are the
///                                    speeds in um/s that the outputs of X and Z pass on
///
/// Lines: `table FILE`, `set PARAMETER VALUE`, `request KIND` (cam_request_t) are carried out at
/// once and end the program with status 1 when they are refused; `tick CLOCK COUNTS INDEX_COUNTS
/// N_INDEX EDGE_CLOCK U_NM X_NM Z_NM INPUTS` calls cam_isr() and answers with `U_NM X_NM Z_NM
/// SPINDLE_MRPM OUTPUTS STATE FAULTS`.
#include "cam_machine.h"
#include "fixture_image.h"
#include "hal_host.h"
#include <inttypes.h> // SCNu32
#include <stdio.h>
#include <stdlib.h> // strtoul
#include <string.h> // strcmp

static cam_machine_t machine;
static fixture_image_t image;

/// The barrel of a thin pin, so that X has a short way from its rest.
static void thin_barrel(double z_nm, double x[3])
{
    const double off = z_nm - 400000.0;
    x[0] = 1.2e5 - 2e-8 * off * off;
    x[1] = -4e-8 * off;
    x[2] = -4e-8;
}

static int write_image(const char *path)
{
    fixture_part_t part = fixture_part_short();
    part.x = thin_barrel;
    part.x_offset_nm = 120000;
    part.feed_nm = 250000;
    fixture_image_make(&image, &part);
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        return 1;
    }
    const size_t n = fwrite(image.bytes, 1, image.size, file);
    return fclose(file) == 0 && n == image.size ? 0 : 1;
}

static bool select_table(const char *path)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return false;
    }
    image.size = fread(image.bytes, 1, sizeof image.bytes, file);
    (void)fclose(file);
    return cam_machine_select_table(&machine, image.bytes, image.size) == cam_ok;
}

static bool request(uint32_t kind)
{
    switch (kind) {
    case cam_request_enable:
        return cam_machine_enable(&machine) == cam_ok;
    case cam_request_disable:
        return cam_machine_disable(&machine) == cam_ok;
    case cam_request_start:
        return cam_machine_start(&machine) == cam_ok;
    case cam_request_stop:
        return cam_machine_stop(&machine) == cam_ok;
    case cam_request_reset:
        return cam_machine_reset(&machine) == cam_ok;
    default:
        return false;
    }
}

static bool tick(const char *line)
{
    const int n = sscanf(line,
                         "tick %" SCNu32 " %" SCNu32 " %" SCNu32 " %" SCNu32 " %" SCNu32 " %" SCNd32
                         " %" SCNd32 " %" SCNd32 " %" SCNu32,
                         &hal_host.clock, &hal_host.in.read.counts, &hal_host.in.read.index_counts,
                         &hal_host.in.read.n_index, &hal_host.in.read.edge_clock,
                         &hal_host.in.axis_nm[hal_axis_u], &hal_host.in.axis_nm[hal_axis_x],
                         &hal_host.in.axis_nm[hal_axis_z], &hal_host.in.inputs);
    if (n != 9) {
        return false;
    }
    cam_isr();
    const cam_status_t status = cam_machine_status(&machine);
    printf("%" PRId32 " %" PRId32 " %" PRId32 " %" PRId32 " %" PRIu32 " %d %" PRIu32 "\n",
           hal_host.out.axis[hal_axis_u].pos_nm, hal_host.out.axis[hal_axis_x].pos_nm,
           hal_host.out.axis[hal_axis_z].pos_nm, hal_host.out.spindle_mrpm, hal_host.out.outputs,
           (int)status.state, status.faults);
    return true;
}

static bool carry_out(const char *line)
{
    char path[512];
    uint32_t number;
    int32_t value;
    if (sscanf(line, "table %511s", path) == 1) {
        return select_table(path);
    }
    if (sscanf(line, "set %" SCNu32 " %" SCNd32, &number, &value) == 2) {
        return cam_machine_set_param(&machine, (cam_param_id_t)number, value) == cam_ok;
    }
    if (sscanf(line, "request %" SCNu32, &number) == 1) {
        return request(number);
    }
    return tick(line);
}

int main(int argc, char **argv)
{
    char line[600];
    if (argc == 3 && strcmp(argv[1], "image") == 0) {
        return write_image(argv[2]);
    }
    if (argc != 5) {
        return 2;
    }
    const uint32_t tick_hz = (uint32_t)strtoul(argv[1], NULL, 10);
    hal_host_reset(tick_hz);
    hal_host.slow.has_edge_time = true; // as the image's port
    hal_host.slow.measures_u = true;
    hal_host.slow.scale[hal_axis_x].most_um_per_s = (int32_t)strtol(argv[3], NULL, 10);
    hal_host.slow.scale[hal_axis_z].most_um_per_s = (int32_t)strtol(argv[4], NULL, 10);
    cam_machine_init(&machine, &g_cam, tick_hz, (uint32_t)strtoul(argv[2], NULL, 10));
    while (fgets(line, sizeof line, stdin) != NULL) {
        if (!carry_out(line)) {
            (void)fprintf(stderr, "refused: %s", line);
            return 1;
        }
    }
    return 0;
}
