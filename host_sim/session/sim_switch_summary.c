// SPDX-License-Identifier: Apache-2.0
#include "sim_switch_summary.h"
#include "sim_summary.h" // sim_summary_number

static const double deg_per_turn = 360.0;

/// @return a parameter of switch i, by the id of the first switch
static double param(const cam_params_t *params, uint32_t i, cam_param_id_t of_first)
{
    const uint32_t n =
        (uint32_t)cam_param_switch_2_per_turn - (uint32_t)cam_param_switch_1_per_turn;
    return cam_param_get(params, (cam_param_id_t)((uint32_t)of_first + i * n));
}

void sim_switch_windows(const cam_params_t *params, sim_switch_window_t *to)
{
    for (uint32_t i = 0; i < sim_switches_n; i++) {
        to[i] = (sim_switch_window_t){
            .per_turn = param(params, i, cam_param_switch_1_per_turn),
            .on_turn = param(params, i, cam_param_switch_1_on_udeg) * 1e-6 / deg_per_turn,
            .off_turn = param(params, i, cam_param_switch_1_off_udeg) * 1e-6 / deg_per_turn,
            .dead_time_s = param(params, i, cam_param_switch_1_dead_time_ns) * 1e-9,
        };
    }
}

static void add_error(cJSON *one, const char *name, const sim_switch_edges_t *edges)
{
    if (edges->n == 0u) {
        (void)cJSON_AddNullToObject(one, name);
        return;
    }
    cJSON *error = cJSON_AddObjectToObject(one, name);
    sim_summary_number(error, "mean", edges->sum_turn / edges->n * deg_per_turn);
    sim_summary_number(error, "max", edges->largest_turn * deg_per_turn);
}

static void add_switch(cJSON *list, uint32_t i, const sim_switch_t *s)
{
    cJSON *one = cJSON_CreateObject();
    sim_summary_number(one, "output", i + 1u);
    sim_summary_number(one, "windows_per_turn", s->window.per_turn);
    sim_summary_number(one, "on_deg", s->window.on_turn * deg_per_turn);
    sim_summary_number(one, "off_deg", s->window.off_turn * deg_per_turn);
    sim_summary_number(one, "dead_time_us", s->window.dead_time_s * 1e6);
    sim_summary_number(one, "times_on", s->on.n);
    sim_summary_number(one, "times_off", s->off.n);
    sim_summary_number(one, "other_on", s->on.n_other);
    sim_summary_number(one, "other_off", s->off.n_other);
    add_error(one, "on_error_deg", &s->on);
    add_error(one, "off_error_deg", &s->off);
    cJSON *z = cJSON_AddArrayToObject(one, "z_mm");
    if (s->low_mm <= s->high_mm) {
        (void)cJSON_AddItemToArray(z, cJSON_CreateNumber(s->low_mm));
        (void)cJSON_AddItemToArray(z, cJSON_CreateNumber(s->high_mm));
    }
    (void)cJSON_AddItemToArray(list, one);
}

void sim_switch_summary(cJSON *root, const sim_switches_t *switches)
{
    cJSON *list = NULL;
    for (uint32_t i = 0; i < sim_switches_n; i++) {
        if (switches->each[i].window.per_turn > 0.0) {
            list = list != NULL ? list : cJSON_AddArrayToObject(root, "switches");
            add_switch(list, i, &switches->each[i]);
        }
    }
}
