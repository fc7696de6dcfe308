// SPDX-License-Identifier: Apache-2.0
/// sim_band: bands of a skirt and its ring belt, which the tool turns one after the other, each in
/// passes of its own: it enters a band from below, feeds upwards through it, retracts, and goes
/// back. The gauge judges the surface that the last pass leaves.
///
/// Bands come from the report of a table (sim_design.h).
#ifndef SIM_BAND_H
#define SIM_BAND_H

#include "common_error.h" // common_error_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool

enum { sim_bands_most = 16, sim_band_most_passes = 16 };

typedef struct {
    double low_mm, high_mm;
    double run_mm; ///< the tool comes in so far below
    int n_passes;
    double allowance_mm[sim_band_most_passes]; ///< stock that each pass leaves
    double feed_mm[sim_band_most_passes];      ///< per turn
    int n_begun;                               ///< passes, at most n_passes
    bool is_below;                             ///< since the last pass the tool has been below
    bool is_inside;                            ///< it is in a pass, on its way upwards
} sim_band_t;

typedef struct {
    int n; ///< 0: the part has no bands
    sim_band_t band[sim_bands_most];
} sim_bands_t;

/// Read "bands" of a report's design.
/// @param b     zero-initialised
/// @param path  of the report, for messages
/// @return      false and *e when something is malformed
bool sim_bands_read(sim_bands_t *b, const cJSON *design, const char *path, common_error_t *e);

/// Follow a cutting tool to a height.
/// @return the band there, also on the way back; NULL in a groove and beyond the bands
const sim_band_t *sim_bands_follow(sim_bands_t *b, double z_mm);

/// @return whether the tool is in the last pass of the band
bool sim_band_is_last(const sim_band_t *band);

/// @return [mm] stock that the tool meets on the drawing; below 0: the blank
double sim_band_stock_mm(const sim_band_t *band);

/// @return whether every pass of every band has begun
bool sim_bands_are_done(const sim_bands_t *b);

/// @return [mm] the largest feed of the last passes; 0 without bands
double sim_bands_feed_mm(const sim_bands_t *b);

/// Forget the passes.
void sim_bands_restart(sim_bands_t *b);

#endif
