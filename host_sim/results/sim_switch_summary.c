// SPDX-License-Identifier: Apache-2.0
#include "sim_switch_summary.h"
#include "sim_summary.h" // sim_summary_number

static const double deg_per_turn = 360.0;

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
