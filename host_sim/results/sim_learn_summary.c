// SPDX-License-Identifier: Apache-2.0
#include "sim_summary.h"
#include "sim_units.h" // sim_round

static const double nm_per_um = 1e3, q6 = 64.0, q12 = 4096.0;

/// Names as on the bus (camturn.dbc).
static const char *const phases[cam_ilc_n_phases] = {
    [cam_ilc_off] = "off",         [cam_ilc_waiting] = "waiting", [cam_ilc_settling] = "settling",
    [cam_ilc_drive] = "drive",     [cam_ilc_probing] = "probing", [cam_ilc_shape] = "shape",
    [cam_ilc_cutting] = "cutting", [cam_ilc_frozen] = "frozen",
};
static const char *const reasons[cam_ilc_n_reasons] = {
    [cam_ilc_all] = "all",
    [cam_ilc_not_asked] = "not_asked",
    [cam_ilc_not_measured] = "not_measured",
    [cam_ilc_no_table] = "no_table",
    [cam_ilc_modulated] = "modulated",
    [cam_ilc_slow_turn] = "slow_turn",
    [cam_ilc_fast_turn] = "fast_turn",
    [cam_ilc_lobes] = "lobes",
    [cam_ilc_diverged] = "diverged",
    [cam_ilc_rippled] = "rippled",
    [cam_ilc_limited] = "limited",
    [cam_ilc_slow_loop] = "slow_loop",
};

static void add_turns(cJSON *root, const sim_turns_t *t)
{
    cJSON *um = cJSON_AddArrayToObject(root, "error_per_turn_um");
    cJSON *where = cJSON_AddObjectToObject(root, "error_per_turn");
    cJSON *turn = cJSON_AddArrayToObject(where, "turn");
    cJSON *state = cJSON_AddArrayToObject(where, "state");
    for (uint32_t i = 0; i < t->n; i++) {
        const sim_turn_t *one = &t->entry[i];
        const char *name = one->kind == sim_turns_cut ? "cutting" : "rehearsing";
        (void)cJSON_AddItemToArray(um, cJSON_CreateNumber(sim_round(one->um * 1e6) / 1e6));
        (void)cJSON_AddItemToArray(turn, cJSON_CreateNumber(sim_round(one->turn * 1e6) / 1e6));
        (void)cJSON_AddItemToArray(state, cJSON_CreateString(name));
    }
}

static void add_masked(cJSON *learning, const cam_ilc_status_t *t)
{
    cJSON *list = cJSON_AddArrayToObject(learning, "masked");
    for (uint32_t k = 0; k <= t->n_harmonics; k++) {
        if ((t->masked >> k & 1u) != 0u) {
            (void)cJSON_AddItemToArray(list, cJSON_CreateNumber(k));
        }
    }
}

static void add_harmonic(cJSON *list, uint32_t k, const cam_ilc_harmonic_t *h)
{
    const double nturn_per_q32 = 1e9 / 4294967296.0;
    cJSON *one = cJSON_CreateObject();
    sim_summary_number(one, "k", k);
    sim_summary_number(one, "re_um", h->correction_q6.re / q6 / nm_per_um);
    sim_summary_number(one, "im_um", h->correction_q6.im / q6 / nm_per_um);
    sim_summary_number(one, "gain_re", h->gain.re / q12);
    sim_summary_number(one, "gain_im", h->gain.im / q12);
    if (h->best_q6 < UINT32_MAX) { // there is one
        sim_summary_number(one, "best_um", h->best_q6 / q6 / nm_per_um);
    }
    sim_summary_number(one, "ripple_re_nturn", h->ripple.re * nturn_per_q32);
    sim_summary_number(one, "ripple_im_nturn", h->ripple.im * nturn_per_q32);
    (void)cJSON_AddBoolToObject(one, "is_masked", h->is_masked);
    (void)cJSON_AddItemToArray(list, one);
}

static void add_learning(cJSON *root, sim_cut_t *cut)
{
    const cam_ilc_status_t t = cam_machine_learning(&cut->firmware.machine);
    const bool is_asked = t.reason != cam_ilc_not_asked && t.reason != cam_ilc_not_measured &&
                          t.reason != cam_ilc_modulated && t.reason != cam_ilc_no_table;
    cJSON *learning = cJSON_AddObjectToObject(root, "learning");
    (void)cJSON_AddBoolToObject(learning, "is_on", is_asked && t.n_turns > 0u);
    sim_summary_text(learning, "phase", phases[t.phase]);
    sim_summary_text(learning, "reason", reasons[t.reason]);
    sim_summary_number(learning, "turns", t.n_turns);
    add_masked(learning, &t);
    sim_summary_number(learning, "k1_ns", t.k1_ns);
    sim_summary_number(learning, "k2_us2", t.k2_us2);
    sim_summary_number(learning, "friction_nm", t.friction_nm);
    sim_summary_number(learning, "chip_nm_per_mm2", t.chip_nm_per_mm2);
    sim_summary_number(learning, "chip_mean_nm_per_mm2", t.chip_mean_nm_per_mm2);
    sim_summary_number(learning, "begin_error_um", t.begin_error_nm / nm_per_um);
    sim_summary_number(learning, "error_um", t.error_nm / nm_per_um);
    sim_summary_number(learning, "correction_um", t.correction_nm / nm_per_um);
    sim_summary_number(learning, "ripple_turns", t.ripple_turns);
    sim_summary_number(learning, "ripple_nturn", t.ripple_nturn);
    cJSON *list = cJSON_AddArrayToObject(learning, "harmonics");
    for (uint32_t k = 0; is_asked && t.n_turns > 0u && k <= t.n_harmonics; k++) {
        const cam_ilc_harmonic_t h = cam_ilc_harmonic(&cut->firmware.machine.ilc, k);
        add_harmonic(list, k, &h);
    }
}

void sim_summary_learning(cJSON *root, sim_cut_t *cut)
{
    add_turns(root, &cut->turns);
    add_learning(root, cut);
}
