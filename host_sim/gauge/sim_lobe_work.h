// SPDX-License-Identifier: Apache-2.0
/// sim_lobe_work: lobe profiles as cut by a wheel or a swinging tool, and their gauge.
///
/// The work is held as dexels: straight lines along the normals of the exact profile, a tenth of a
/// degree of the roller's direction apart. Each is cut off at the deepest reach of the tool's
/// circle,
///
///     left = min over time of  w.n - sqrt(R^2 - (w x n)^2),   w = centre of the circle - foot
///
/// so the length left on a line is the error of the profile along its normal, MATHS.md (66). The
/// circle is the wheel, or the tip of the tool, which reaches r1 from the swing's centre:
///
///     centre of the wheel  (X - U) at the spindle's angle
///     centre of the tip    the same, minus (r1 - tip) along the tool's line, which the swing turns
///
/// Between ticks the lathe moves along the parabola through three ticks. The cut of each dexel runs
/// along the parabola through both ends and the middle of a piece; in each piece the contact
/// travels less than a quarter of R, so the error is below 3e-6 R or 1 nm. A dexel is finished when
/// the contact has passed it and the circle is more than 5 um above it. Each turn cuts its own
/// ring, as wide as the feed (as in sim_work), and the next turn starts with fresh lines. A
/// plunging wheel cuts the same lines deeper in every turn: they are gauged once, when it moves to
/// the next lobe or disengages. Cuts are searched only near the contact: the generator refuses
/// wheels that would cut elsewhere. Between two lobes only cuts below the base circle count.
#ifndef SIM_LOBE_WORK_H
#define SIM_LOBE_WORK_H

#include "sim_lobe_design.h" // sim_lobe_design_t
#include "sim_removal.h"     // sim_spread_t
#include "sim_work.h"
#include <stdbool.h> // bool
#include <stdint.h>  // int64_t, uint64_t

enum { sim_lobe_dexels = 3600 };

/// State of the machine at an instant.
typedef struct {
    double t_s;
    double turn;      ///< [turn] drawing's angle less the operator's phase, not wrapped
    double centre_mm; ///< X - U: distance of the follower's centre from the axis
    double swing_deg; ///< of the tool from the line of centres; not used by a wheel
    double z_mm;      ///< height of the tool
    double due_rad_s; ///< spindle speed that the table demands here
    bool is_counted;  ///< the sample belongs to the judged surface
} sim_lobe_tool_t;

/// A line along the normal of the profile.
typedef struct {
    double x_mm, y_mm, nx, ny; ///< foot on the exact profile and direction
    double turn;               ///< polar angle of the foot on the shaft, 0 .. 1
    double radius_mm;          ///< of the foot
    double left_mm;            ///< height above the foot at which it is cut off
    bool is_clean;             ///< all samples that cut it were counted
} sim_lobe_dexel_t;

/// Gauge of a lobe.
typedef struct {
    double max_um, sum_um2;
    double max_turn, max_z_mm; ///< place of the largest
    uint64_t n;
} sim_lobe_gauge_t;

typedef struct {
    sim_lobe_design_t *design;
    sim_work_t *work;          ///< also receives finished dexels
    sim_sections_t *sections;  ///< likewise; NULL: no sections
    double circle_mm;          ///< radius of wheel or tip
    double whole_mm;           ///< circle_mm before the first lobe
    double wear_mm;            ///< wear of circle_mm per lobe
    double sense;              ///< of cutting: 1 (M3), -1 (M4)
    uint32_t i_lobe;           ///< n_lobes: none
    double theta_rad;          ///< last contact, in the sense of cutting, not wrapped
    double gap_mm;             ///< from the exact profile to the circle there
    double contact_turn;       ///< polar angle of the contact on the shaft, 0 .. 1
    double contact_mm;         ///< radius of the exact profile there
    uint32_t n_before;         ///< instants in `before`, 0 .. 2
    sim_lobe_tool_t before[2]; ///< the last instant, and the one before that
    sim_lobe_spot_t spot;      ///< of the last contact
    int64_t first, end;        ///< range of dexels still to be cut, not wrapped
    sim_lobe_gauge_t gauge[sim_lobe_design_max];
    sim_spread_t speed_mm_s;  ///< of the contact along the profile
    sim_spread_t off_plan;    ///< that speed over the planned speed, minus 1
    sim_spread_t rake_deg;    ///< tool's line from the normal at the contact
    sim_spread_t unswung_deg; ///< rake of a tool that does not swing
    sim_lobe_dexel_t dexel[sim_lobe_dexels];
} sim_lobe_work_t;

/// @param w       300 KB: allocate it
/// @param design  must outlive the work
/// @param work    initialised; takes the samples
/// @param direction  1 (M3) or -1 (M4): sense of cutting
/// @param tip_mm   radius of the tool's tip, at most the roller's; not used by a wheel
/// @param wear_mm  wear of the wheel's radius per lobe
void sim_lobe_work_init(sim_lobe_work_t *w, sim_lobe_design_t *design, sim_work_t *work,
                        int direction, double tip_mm, double wear_mm);

/// Move the tool and cut.
/// @param tool  t_s rises from call to call
void sim_lobe_work_cut(sim_lobe_work_t *w, const sim_lobe_tool_t *tool);

/// @return [um] rms error of a lobe, 0 without samples
double sim_lobe_gauge_rms_um(const sim_lobe_gauge_t *g);

#endif
