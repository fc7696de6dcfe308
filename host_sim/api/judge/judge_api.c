// SPDX-License-Identifier: Apache-2.0
#include "judge_api.h"
#include "cam_feasible.h" // cam_feasible_demands
#include <math.h>         // fmax, fmin, floor
#include <stdlib.h>       // aligned_alloc, calloc, free
#include <string.h>       // memcpy

enum { alignment = 32, n_demands = cam_n_demands + 1 };

struct judge_api {
    void *image;
    cam_err_t err; ///< of the image
    cam_table_t table;
    cam_params_t params;
    uint32_t tick_hz;
    judge_api_demand_t demands[n_demands];
};

judge_api_t *judge_api_open(const void *image, size_t size, uint32_t tick_hz)
{
    judge_api_t *j = calloc(1, sizeof *j);
    void *copy = aligned_alloc(alignment, (size / alignment + 1u) * alignment);
    if (j == NULL || copy == NULL) {
        free(j);
        free(copy);
        return NULL;
    }
    (void)memcpy(copy, image, size);
    j->image = copy;
    j->err = cam_table_check(copy, size, &j->table);
    j->params = cam_param_defaults();
    j->tick_hz = tick_hz;
    return j;
}

/// The speed of a table of peaks is modulated without knots that anybody reads.
static const cam_knot_t no_knot;

judge_api_t *judge_api_open_peaks(const judge_api_peaks_t *peaks, uint32_t tick_hz)
{
    judge_api_t *j = calloc(1, sizeof *j);
    if (j == NULL) {
        return NULL;
    }
    const bool is_modulated = peaks->ratio_max_q20 > (uint32_t)CAM_TABLE_RATIO_ONE;
    j->params = cam_param_defaults();
    j->tick_hz = tick_hz;
    j->table = (cam_table_t){
        .speed.knots = is_modulated ? &no_knot : NULL,
        .n_lobes = 1,
        .least_change_nm = peaks->change_nm,
        .is_swung = peaks->swing_mdeg > 0u,
        .swing = {peaks->swing_mdeg, peaks->swing1_mdeg_per_rad, peaks->swing2_mdeg_per_rad2},
        .z_last_nm = (int32_t)peaks->span_nm,
        .feed_nm = peaks->feed_nm,
        .limit_u_stroke_nm = UINT32_MAX,
        .limit_u_speed_um_per_s = UINT32_MAX,
        .limit_u_acceleration_mm_per_s2 = UINT32_MAX,
        .limit_spindle_mrpm = UINT32_MAX,
        .u_max_nm = (int32_t)peaks->u_nm,
        .u1_peak_nm_per_rad = peaks->u1_peak_nm_per_rad,
        .u2_peak_nm_per_rad2 = peaks->u2_peak_nm_per_rad2,
        .spindle_peak_ppm_per_rad = peaks->spindle_peak_ppm_per_rad,
        .ratio_max_q20 = peaks->ratio_max_q20,
    };
    return j;
}

void judge_api_close(judge_api_t *j)
{
    if (j != NULL) {
        free(j->image);
        free(j);
    }
}

const char *judge_api_refusal(const judge_api_t *j)
{
    return j->err == cam_ok ? "" : cam_err_text(j->err);
}

bool judge_api_set(judge_api_t *j, const char *name, double value)
{
    const cam_param_id_t id = cam_param_find(name);
    const cam_param_info_t *info = cam_param_info(id);
    return info != NULL &&
           cam_param_set(&j->params, id,
                         (int32_t)fmin(fmax(floor(value + 0.5), info->min), info->max)) == cam_ok;
}

/// @return name of the error of a limit
static const char *name_of(cam_err_t err)
{
    switch (err) {
#define NAME(name, number, text)                                                                   \
    case cam_err_##name:                                                                           \
        return #name;
        CAM_ERRORS(NAME)
#undef NAME
    case cam_ok:
        break;
    }
    return "";
}

static judge_api_demand_t named(const cam_demand_t *d)
{
    return (judge_api_demand_t){name_of(d->err), d->limit, (int64_t)d->needed};
}

const judge_api_demand_t *judge_api_demands(judge_api_t *j, uint32_t mrpm, size_t *n)
{
    cam_demands_t axes;
    const cam_demand_t turns = cam_feasible_demands(&j->table, &j->params, mrpm, j->tick_hz, &axes);
    for (size_t i = 0; i < (size_t)cam_n_demands; i++) {
        j->demands[i] = named(&axes.of[i]);
    }
    j->demands[cam_n_demands] = named(&turns);
    *n = n_demands;
    return j->demands;
}

uint32_t judge_api_highest_mrpm(const judge_api_t *j)
{
    return cam_feasible_highest_mrpm(&j->table, &j->params, j->tick_hz);
}

uint32_t judge_api_largest_feed_nm(const judge_api_t *j, uint32_t mrpm)
{
    return cam_feasible_largest_feed_nm(&j->table, &j->params, mrpm, j->tick_hz);
}
