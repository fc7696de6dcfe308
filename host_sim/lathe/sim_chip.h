// SPDX-License-Identifier: Apache-2.0
/// sim_chip: radial cutting force, which pushes U back and bends the tool.
///
///     F = kc depth h share,     h = |dz/dt| / |turns per second|
///     U is accelerated by -F / mass, the tip yields by F / stiffness
///
/// depth is that of the tip below the blank, h the present feed per turn, share the radial share of
/// the cutting force. The force is 0 while the tool is clear of the blank. Source: MATHS.md (125);
/// Kienzle's kc with the share of the passive force, e.g. Tschaetsch, "Metal Forming Practise" and
/// Altintas, "Manufacturing Automation", 2nd ed., 2.2.
/// It is 0 in slots, which the gauge leaves out.
///
/// The force at the end of a step is held through the next one, so on average it acts on U 1.5
/// steps late (75 us at 20 kHz). Bend and depth depend on each other; the gain of that loop is kc h
/// share / stiffness: 0.003 for 700 N/mm2, 0.1 mm, 0.3 and 20 N/um, and below 1 for every possible
/// cut.
#ifndef SIM_CHIP_H
#define SIM_CHIP_H

#include <stdbool.h> // bool

enum { sim_chip_slots = 4 };

/// A window of the blank without material, such as a slot or the bore of a pin.
typedef struct {
    double middle_deg, width_deg; ///< angle of the drawing; width 0: no slot
    double low_mm, high_mm;       ///< heights, both ends included
} sim_chip_slot_t;

typedef struct {
    double kc_n_per_mm2;            ///< specific cutting force; 0: no force
    double radial_share;            ///< radial share of the force
    double tool_stiffness_n_per_um; ///< between tip and slide; 0: rigid
    sim_chip_slot_t slot[sim_chip_slots];
} sim_chip_config_t;

/// No force, a radial share of 0.3, a rigid tool, no slots.
sim_chip_config_t sim_chip_defaults(void);

/// @param depth_mm   below the blank; 0 or below: clear
/// @param z_mm_per_s, turns_per_s  signed
/// @return [N] radial force away from the axis, >= 0; 0 while the spindle is stopped
double sim_chip_force_n(const sim_chip_config_t *c, double depth_mm, double z_mm_per_s,
                        double turns_per_s);

/// @param turn  [turn] angle of the drawing
/// @return whether there is no material at a place of the blank
bool sim_chip_is_in_slot(const sim_chip_config_t *c, double turn, double z_mm);

/// @return [um] bend of the tip away from the axis
double sim_chip_bend_um(const sim_chip_config_t *c, double force_n);

#endif
