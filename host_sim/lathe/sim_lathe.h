// SPDX-License-Identifier: Apache-2.0
/// sim_lathe: spindle, encoder and four drives: the same lathe for every controller.
///
/// The lathe knows only set-points and time: port/sim_port.h connects it to the firmware in this
/// process, bus/sim_bus.h to the nodes of a CAN bus. Convention: turn is the drawing's angle at the
/// tool (PARTFILE.md). It rises in the machine's positive sense (M3), the sense of a positive
/// spindle set-point.
///
/// The position of U's tip is its slide plus the motion of the modes and the bending by the chip.
/// The scale of U measures the slide and the modes that act on the scale. The run-out of the
/// spindle moves the part: runout cos(2 pi turn) + runout_2 cos(4 pi turn) are added to X, the
/// distance of the tool from the axis, MATHS.md (128).
#ifndef SIM_LATHE_H
#define SIM_LATHE_H

#include "hal/hal.h"   // hal_axis_t
#include "sim_drive.h" // sim_drive_t
#include "sim_encoder.h"
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, uint32_t, uint64_t

// Radial cutting force, which pushes U back and bends the tool.
//
//     F = kc depth h share,     h = |dz/dt| / |turns per second|
//     U is accelerated by -F / mass, the tip yields by F / stiffness
//
// depth is that of the tip below the blank, h the present feed per turn, share the radial share of
// the cutting force. The force is 0 while the tool is clear of the blank. Source: MATHS.md (125);
// Kienzle's kc with the share of the passive force, e.g. Tschaetsch, "Metal Forming Practise" and
// Altintas, "Manufacturing Automation", 2nd ed., 2.2.
//
// The force at the end of a step is held through the next one, so on average it acts on U 1.5
// steps late (75 us at 20 kHz). Bend and depth depend on each other; the gain of that loop is kc h
// share / stiffness: 0.003 for 700 N/mm2, 0.1 mm, 0.3 and 20 N/um, and below 1 for every possible
// cut.

typedef struct {
    double kc_n_per_mm2;            ///< specific cutting force; 0: no force
    double radial_share;            ///< radial share of the force
    double tool_stiffness_n_per_um; ///< between tip and slide; 0: rigid
} sim_chip_config_t;

/// @param depth_mm   below the blank; 0 or below: clear
/// @param z_mm_per_s, turns_per_s  signed
/// @return [N] radial force away from the axis, >= 0; 0 while the spindle is stopped
double sim_chip_force_n(const sim_chip_config_t *c, double depth_mm, double z_mm_per_s,
                        double turns_per_s);

/// @return [um] bend of the tip away from the axis
double sim_chip_bend_um(const sim_chip_config_t *c, double force_n);

// A chuck whose jaws spring the part: a thin elastic ring under n equal radial forces F.
//
//     w(x) = F R^3 / (2 E I) (c cos x + x sin x / (2 sin a) - 1 / a),    |x| <= a = pi / n
//     c = (sin a + a cos a) / (2 sin^2 a),    I = length wall^3 / 12
//
// x is the angle from the middle between two jaws. The jaws press the ring inwards by w(a) and it
// bulges by -w(0) between them; its length is kept, so the mean of w is 0. The tool cuts the
// radius r into the clamped part. Released, that surface is at r + w: metal is left at the jaws.
// Source: MATHS.md (247); Timoshenko, "Strength of Materials", part II; Roark, "Formulas for
// Stress and Strain", 7th ed., table 9.2, case 7.

typedef struct {
    double jaws;            ///< n, whole, at equal distances
    double jaw_deg;         ///< of one of them, on the spindle
    double spring_um;       ///< w(a) - w(0) at the jaws; below 0: they expand inside the part
    double jaw_height_mm;   ///< where they press
    double round_height_mm; ///< where the part stays round, spring linear up to the jaws; the same
                            ///< height: spring alike at all heights
} sim_chuck_config_t;

/// @param turn  [turn] angle of the spindle, not wrapped
/// @return [mm] w: radius of the released part less the radius that the tool cuts
double sim_chuck_sprung_mm(const sim_chuck_config_t *c, double turn, double z_mm);

// References for homing a slide: a switch at the end of its travel, index marks of its scale or
// encoder, and the zero of its scale.

typedef struct {
    double switch_mm; ///< position of the switch's edge
    double side;      ///< above 0: active from there upwards; below 0: downwards; 0: no switch
    double pitch_mm;  ///< distance of index marks, one of them at the scale's zero; 0: none
    double zero_mm;   ///< position where the scale counts 0
} sim_home_config_t;

typedef struct {
    sim_home_config_t config;
    bool is_used;        ///< there is a switch or an index
    int32_t zero_nm;     ///< position where the scale counts 0
    double last_mm;      ///< last position
    uint32_t n_left;     ///< [ticks] for which the last index is still shown
    bool is_on, is_seen; ///< on the switch; an index is shown
} sim_home_t;

/// @param place_mm  position of the slide at the start
void sim_home_init(sim_home_t *h, const sim_home_config_t *config, double place_mm);

/// Update with the position of the slide, once per tick.
/// @param n_shown  [ticks] for which an index is shown
void sim_home_look(sim_home_t *h, double place_mm, uint32_t n_shown);

// A flexible mode between the slide of U and the tip of its tool.
//
//     d2q/dt2 + 2 d w dq/dt + w^2 q = -share d2x/dt2          tip = x + q
//
// x is the position of the slide, q that of the tip relative to it. For slow motion q = -share a /
// w^2. The scale measures a mode that is on the scale; any other is between scale and tip. The
// mode does not push back: its mass counts as part of the slide's. Source: MATHS.md (123); a
// base-excited oscillator, e.g. Preumont, "Vibration Control of Active Structures", 3rd ed., 2.2.
//
// Discretisation: with y = x + q / share the equation is driven by x and dx/dt. x is the cubic
// through positions and speeds at both ends of a piece; for a cubic the flow is exact. A jump J of
// the acceleration inside a piece of length T causes an error of x below J T^2 / 64, 1 nm at 20
// m/s2 and 50 us, and a smaller error of q; for a smooth x the error is T^4 x'''' / 384.

enum { sim_mode_n = 2 }; ///< modes of a machine

typedef struct {
    double hz;          ///< w / 2 pi; 0: no mode
    double damping;     ///< d
    double share;       ///< share of the slide's acceleration that moves the tip; below 0: forwards
    double is_on_scale; ///< 1: the scale measures it; 0: it is between scale and tip
} sim_mode_config_t;

typedef struct {
    double omega_rad_per_s, damping, share;
    bool is_on_scale;
    double pos_micro, vel_micro_per_s; ///< y - x: motion of the tip for a share of 1
} sim_mode_t;

/// Motion of the slide over a piece: state at both ends.
typedef struct {
    double pos_micro[2], vel_micro_per_s[2];
} sim_mode_travel_t;

/// Start at rest.
void sim_mode_init(sim_mode_t *m, const sim_mode_config_t *config);

/// Advance over a piece of the slide's motion.
/// @param dt_s  >= 0
void sim_mode_step(sim_mode_t *m, const sim_mode_travel_t *travel, double dt_s);

/// @return [micro] position of the tip relative to the slide
double sim_mode_tip_micro(const sim_mode_t *m);

// The lathe

/// Drives: the axes in the order of hal_axis_t, then the swing of the tool.
enum { sim_lathe_swing = hal_n_axes, sim_lathe_n_drives };

/// Contents of a machine file; sim_drive.h explains the units of the drives.
typedef struct {
    double tick_hz; ///< of the controller
    sim_spindle_config_t spindle;
    sim_encoder_config_t encoder;
    sim_drive_config_t drive[sim_lathe_n_drives]; ///< speed 0 of the swing: the machine has none
    sim_home_config_t home[hal_n_axes];
    double swing_range_deg;             ///< travel of the swing to either side
    sim_mode_config_t mode[sim_mode_n]; ///< of U
    sim_scale_config_t scale;           ///< of U
    sim_chip_config_t chip;             ///< of a skirt's tool
    sim_chuck_config_t chuck;           ///< of a part that is turned by sections
    double runout_um, runout_2_um; ///< run-out of the spindle once and twice per turn, amplitudes
    double u_stroke_mm;            ///< travel of U peak to peak, centred on 0
    double spindle_limit_rpm;      ///< highest speed of the spindle
    double x_start_mm;             ///< X at the start, above the blank's radius
    double z_start_mm;             ///< Z at the start, before the part's first height
    double tool_nose_mm;           ///< radius of the nose, 0: a point, below 0: that of the table
    double tool_wear_um;           ///< wear of the tip
    double wheel_wear_um;          ///< wear of a wheel's radius per lobe
} sim_lathe_config_t;

/// Set-points of the controller for one step.
typedef struct {
    double spindle_rad_per_s;
    double force_n;                      ///< of U, where it takes forces
    int32_t micro[sim_lathe_n_drives];   ///< positions: nm of the axes, micro-degrees of the swing
    bool is_enabled[sim_lathe_n_drives]; ///< false: the drive brakes to rest and holds
} sim_setpoints_t;

/// The true state at an instant.
typedef struct {
    double t_s;
    double turn;             ///< [turn] angle of the spindle, not wrapped
    double u_nm, x_nm, z_nm; ///< tool tip; X includes the spindle's run-out
    double swing_deg; ///< angle of the tool about the swing's centre, 0 along the line of centres
} sim_sample_t;

typedef struct {
    double step_s;
    sim_spindle_t spindle;
    sim_encoder_t encoder;
    sim_drive_t drive[sim_lathe_n_drives];
    sim_mode_t mode[sim_mode_n];
    sim_scale_t scale;
    sim_chip_config_t chip;
    bool is_scale_ideal; ///< U has no modes, and its scale neither latency nor error
    double runout_nm, runout_2_nm;
    double chip_n;   ///< present radial cutting force
    double unread_s; ///< time since the last reading of the encoder
    // injected faults
    bool is_scale_stuck;    ///< the scale of U shows stuck_micro
    int32_t stuck_micro;    ///< reading at the moment it stuck
    bool is_force_reversed; ///< the force of U acts against its command
    double push_n;          ///< force on U besides that of the chip
    bool is_speed_forced;   ///< the spindle runs at forced_rad_per_s, whatever is commanded
    double forced_rad_per_s;
    bool is_reversed;           ///< the spindle turns against its set-point
    uint32_t count_offset;      ///< [counts] added to the counter and to the index latch
    double count_rate;          ///< [1] by which it counts faster
    double rated_counts;        ///< [counts] gained by that rate
    uint32_t dither_counts;     ///< [counts] by which a counter that is stuck dithers
    uint32_t n_readings;        ///< of the encoder
    bool is_encoder_stuck;      ///< the counter keeps stuck_counts
    bool is_index_dead;         ///< no index edge arrives any more
    uint32_t stuck_counts;      ///< counter at the moment it stuck
    hal_encoder_t last_index;   ///< reading at the moment the index died
    hal_encoder_t true_reading; ///< last reading without the faults
} sim_lathe_t;

/// Start with the lathe at rest.
/// @param l       39 KB
/// @param step_s  time between two set-points
/// @param x_nm, z_nm  positions at the start
/// @param seed    seed of all noise
void sim_lathe_init(sim_lathe_t *l, const sim_lathe_config_t *config, double step_s, double x_nm,
                    double z_nm, uint64_t seed);

/// Apply set-points and advance by one step.
void sim_lathe_step(sim_lathe_t *l, const sim_setpoints_t *set);

/// Likewise for another time than a step: set-points that come early, or another clock.
/// @param dt_s  above 0; sim_lathe_step() is faster for a nominal step
void sim_lathe_step_in(sim_lathe_t *l, const sim_setpoints_t *set, double dt_s);

/// Advance with the present set-points, because the next ones are late. The delay lines of the
/// drives are held meanwhile, so commands take effect later by the same amount.
void sim_lathe_linger(sim_lathe_t *l, const sim_setpoints_t *set, double late_s);

/// Set the depth of the skirt's tool in the blank: the cutting force acts from now on.
/// @param depth_mm  0 or below: clear of the blank
void sim_lathe_bite(sim_lathe_t *l, double depth_mm);

/// @return the position that a drive's scale shows, in micro
int32_t sim_lathe_measured_micro(const sim_lathe_t *l, int drive);

/// Read the encoder with its faults. At most one turn may pass between two readings.
hal_encoder_t sim_lathe_encoder(sim_lathe_t *l);

/// Stop the counter.
void sim_lathe_stick_encoder(sim_lathe_t *l);

/// Stop reporting index edges.
void sim_lathe_kill_index(sim_lathe_t *l);

/// @param t_s  [s] controller's clock
sim_sample_t sim_lathe_sample(const sim_lathe_t *l, double t_s);

/// @return true when a drive is slower than 1 um/s
bool sim_lathe_drive_rests(const sim_lathe_t *l, int drive);

/// @return true when the spindle is slower than 0.01 rad/s
bool sim_lathe_spindle_rests(const sim_lathe_t *l);

#endif
