// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_lift: lift of the roller's centre by a lobe, over the follower's angle.
///
///     poly345   H = L (10 u^3 - 15 u^4 + 6 u^5),  u = 1 - |theta| / half angle, 0 outside
///     disc      H = sqrt(reach^2 - (e sin theta)^2) + e cos theta - (reach - e)
///     pieces    quintic over each piece of one turn, periodic
///     flanks    a rise, a dwell about the angle 0, a fall (sim_lobe_flank.h)
///
/// Written from the equations MATHS.md (37), (38), independent of the generator, so that its errors
/// show. Error: rounding only.
#ifndef SIM_LOBE_LIFT_H
#define SIM_LOBE_LIFT_H

#include "common_error.h"   // common_error_t
#include "sim_lobe_flank.h" // sim_lobe_flanks_t
#include <cjson/cJSON.h>
#include <stdbool.h> // bool
#include <stddef.h>  // size_t

enum { sim_lobe_lift_terms = 6 };

typedef enum {
    sim_lobe_lift_poly345,
    sim_lobe_lift_disc,
    sim_lobe_lift_pieces,
    sim_lobe_lift_flanks
} sim_lobe_law_t;

typedef struct {
    sim_lobe_law_t law;
    double lift_mm, half_angle_rad; ///< poly345
    double reach_mm, offset_mm;     ///< disc: its radius plus the roller's; distance of its
                                    ///< centre from the axis
    sim_lobe_flanks_t flanks;
    double *break_rad;                ///< pieces: n + 1 rising angles over one turn
    double (*c)[sim_lobe_lift_terms]; ///< [mm/rad^k] n pieces, highest power first
    size_t n;
    size_t i_last; ///< piece of the last look-up, start of the next search
} sim_lobe_lift_t;

/// Read a law from a lobe of a report.
/// @param lift   zero-initialised; the caller frees it, also on failure
/// @param where  dotted path of the lobe, for messages
/// @return       false and *e when something is missing or malformed
bool sim_lobe_lift_read(sim_lobe_lift_t *lift, const cJSON *lobe, const char *where,
                        const char *path, common_error_t *e);

/// @param theta_rad  any angle of the follower
sim_lobe_rise_t sim_lobe_lift_at(sim_lobe_lift_t *lift, double theta_rad);

void sim_lobe_lift_free(sim_lobe_lift_t *lift);

#endif
