// SPDX-License-Identifier: Apache-2.0
/// sim_area: parts of a turned surface. Windows have no material: a bore, a slot, a cut-out. Zones
/// have tolerances of their own.
///
/// A box is `width_deg` of angle about `middle_deg`, from `low_mm` to `high_mm`. A bore is round: a
/// cylinder of `diameter_mm` whose axis is normal to that of the part, at `middle_deg` and
/// `low_mm`. It meets a surface of radius r where
///
///     (r sin(phi - middle) - offset)^2 + (z - low)^2 < (diameter / 2)^2,   cos(phi - middle) > 0
///
/// Windows and zones come from the report of a table (sim_design.h).
#ifndef SIM_AREA_H
#define SIM_AREA_H

#include "common_error.h" // common_error_t
#include "sim_json.h"     // sim_cubics_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stdint.h>  // uint64_t

enum { sim_areas_most_windows = 80, sim_areas_most_zones = 16, sim_area_name_size = 32 };

typedef struct {
    double middle_deg, width_deg; ///< of the drawing
    double low_mm, high_mm;
    double diameter_mm; ///< of a bore; 0: a box
    double offset_mm;   ///< of a bore's axis from that of the part, towards rising angles
    double margin_mm;   ///< of a window: no verdict on the surface so near its edge
} sim_area_t;

/// A zone of the verdict.
typedef struct {
    sim_area_t area;
    char name[sim_area_name_size];
    double tolerance_um;             ///< largest good form error; 0: that of the part
    bool has_band;                   ///< the form error must stay between two curves, too
    sim_cubics_t lower_um, upper_um; ///< ... of the radius over the height
    double excess_um;                ///< largest excess over tolerance and band; below 0: inside
    double max_um, sum_um2;          ///< form error: largest magnitude, sum of squares
    double max_turn, max_z_mm;       ///< place of the largest
    uint64_t n;                      ///< judged samples
} sim_zone_t;

typedef struct {
    int n_windows, n_zones;
    sim_area_t window[sim_areas_most_windows];
    sim_zone_t zone[sim_areas_most_zones];
    double excess_um; ///< largest excess of the whole surface, over what holds at its place
    double rest_um;   ///< ... of the surface beside the zones
} sim_areas_t;

/// What a place of the surface is.
typedef enum {
    sim_place_metal,
    sim_place_edge, ///< metal within the margin of a window: not judged
    sim_place_air,  ///< in a window
} sim_place_kind_t;

/// Read "windows" and "zones" of a report's design.
/// @param a       zero-initialised; the caller frees it, also on failure
/// @param path    of the report, for messages
/// @return        false and *e when something is malformed
bool sim_areas_read(sim_areas_t *a, const cJSON *design, const char *path, common_error_t *e);

/// @param turn       [turn] drawing's angle, any
/// @param radius_mm  of the surface there
/// @param margin_mm  by which the area is enlarged on all sides
bool sim_area_holds(const sim_area_t *a, double turn, double z_mm, double radius_mm,
                    double margin_mm);

/// @return what the surface is at a place
sim_place_kind_t sim_areas_kind(const sim_areas_t *a, double turn, double z_mm, double radius_mm);

/// @return [um] the largest good form error in a zone, which may be that of the part
double sim_zone_tolerance_um(const sim_zone_t *z, double of_part_um);

/// Judge a sample by the first zone that holds it, or else by the tolerance of the part.
/// @param error_um      form error
/// @param tolerance_um  of the part
void sim_areas_judge(sim_areas_t *a, double turn, double z_mm, double radius_mm, double error_um,
                     double tolerance_um);

/// Forget what was judged.
void sim_areas_restart(sim_areas_t *a);

void sim_areas_free(sim_areas_t *a);

#endif
