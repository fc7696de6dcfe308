// SPDX-License-Identifier: Apache-2.0
component replay "gives camturn what it sensed in a recorded cut, tick by tick, and keeps what it commands";
pin out s32 spindle_rawcounts;
pin out s32 spindle_counts;
pin io bit index_enable;
pin out bit enable;
pin out bit start;
pin out bit estop_ok;
pin out bit drive_ready;
pin out float u_fb;
pin out float x_fb;
pin out float z_fb;
pin out bit u_limit_low;
pin out bit u_limit_high;
pin in float u_cmd;
pin in float x_cmd;
pin in float z_cmd;
pin in float u_force;
pin in float spindle_speed_cmd;
pin in bit drive_enable;
pin in bit fault;
pin in bit in_cut;
pin out bit done "all rows were played";
function feed "in front of camturn.update";
function note "behind camturn.poll";
modparam dummy rows "file of rows, see row_t";
modparam dummy kept "file that is written when the component is unloaded";
option singleton yes;
option extra_setup yes;
option extra_cleanup yes;
license "GPL";
;;
#include <stdio.h>
#include <stdlib.h>

static char *rows = "";
RTAPI_MP_STRING(rows, "file of rows");
static char *kept = "";
RTAPI_MP_STRING(kept, "file of what was commanded");

// Ticks in front of the first row: whole plans of every rate, and one in which camturn does not run yet.
enum { before = 961 };

typedef struct {
    int32_t raw, counts, n_index, u_nm, x_nm, z_nm, inputs, enables, starts;
} row_t;

typedef struct {
    int32_t u_nm, x_nm, z_nm, force_q6, spindle_mrpm, outputs;
} kept_t;

static row_t *row;
static kept_t *keep;
static int n_rows, at;

EXTRA_SETUP()
{
    (void)prefix;
    (void)extra_arg;
    FILE *f = fopen(rows, "rb");
    if (f == NULL) {
        return -ENOENT;
    }
    fseek(f, 0, SEEK_END);
    n_rows = (int)(ftell(f) / (long)sizeof *row);
    rewind(f);
    row = malloc((size_t)n_rows * sizeof *row);
    keep = malloc((size_t)n_rows * sizeof *keep);
    const size_t n = fread(row, sizeof *row, (size_t)n_rows, f);
    fclose(f);
    at = -before;
    return n == (size_t)n_rows ? 0 : -EIO;
}

EXTRA_CLEANUP()
{
    FILE *f = fopen(kept, "wb");
    if (f != NULL) {
        fwrite(keep, sizeof *keep, (size_t)(at > 0 ? at : 0), f);
        fclose(f);
    }
}

FUNCTION(feed)
{
    const row_t *r = &row[at < 0 ? 0 : at < n_rows ? at : n_rows - 1];
    const row_t *last = at > 0 ? r - 1 : r;
    spindle_rawcounts = r->raw;
    spindle_counts = r->counts;
    index_enable = r->n_index == last->n_index ? index_enable : 0;
    u_fb = r->u_nm * 1e-6;
    x_fb = r->x_nm * 1e-6;
    z_fb = r->z_nm * 1e-6;
    estop_ok = (r->inputs & 1) == 0;
    drive_ready = (r->inputs & 2) != 0;
    u_limit_low = (r->inputs & 0x800) != 0;
    u_limit_high = (r->inputs & 0x1000) != 0;
    enable = at >= 0 && r->enables;
    start = at >= 0 && r->starts;
}

static int32_t nm(double mm)
{
    return (int32_t)(mm < 0.0 ? mm * 1e6 - 0.5 : mm * 1e6 + 0.5);
}

FUNCTION(note)
{
    if (at >= 0 && at < n_rows) {
        const double speed = spindle_speed_cmd * 1e3;
        keep[at] = (kept_t){
            nm(u_cmd), nm(x_cmd), nm(z_cmd), nm(u_force * 0.064), (int32_t)(speed < 0.0 ? speed - 0.5 : speed + 0.5),
            drive_enable | fault << 1 | in_cut << 2,
        };
    }
    at += at < n_rows;
    done = at == n_rows;
}
