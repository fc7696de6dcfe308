// SPDX-License-Identifier: Apache-2.0
/// cam_param: every number that a machine builder may set, with unit, range and default; how they
/// are refused, kept and protected.
///
/// CAM_PARAMS lists X(name, min, default, max, flags, what). The name ends in the unit. Parameters
/// are int32 and reach the interrupt through cam_build_config().
///
/// Hard limits: a port's builder may fix limits of parameters when its image is built. CMake's
/// CAM_HARD_LIMITS names a header with a list of X(id, name, least, most); id is passed on
/// (example: tests/unit/firmware/hard_limits/hard_limits.h). No source, be it the bus, a file or
/// the store, can set a listed parameter outside its range, and its default is clamped to it. The
/// ranges of CAM_PARAMS hold as well. following_limit_nm = 0 derives the limit from the part, so a
/// list that bounds it must begin above 0.
///
/// Read the list and its functions first, then refusals, the stored text, the rights to change
/// parameters, and last numbers as text. All functions: slow side, one caller.
#ifndef CAM_PARAM_H
#define CAM_PARAM_H

#include "cam_err.h" // cam_err_t
#include "hal/hal.h" // hal_params_t, hal_operator_t
#include <stdbool.h> // bool
#include <stdint.h>  // int32_t, int64_t, uint8_t, uint32_t

// clang-format off
#define CAM_PARAMS(X) \
    X(counts_per_turn,               64,      10000,   16777216, cam_flag_off, "encoder counts per turn, four per line") \
    X(encoder_sign,                  -1,          1,          1, cam_flag_off | cam_flag_sign, "-1 when counts fall while the spindle turns in its positive sense; 0 is refused") \
    X(index_offset_udeg,     -180000000,          0,  180000000, cam_flag_off, "drawing's angle before the tool at the index, whatever the sense of cutting") \
    X(index_tolerance_counts,         0,          0,    1000000, 0, "accepted deviation of the index from its position; jitter of the encoder") \
    X(jump_window_counts,             0,          0,    1000000, 0, "accepted deviation of one tick's counts from what the speed predicts; 0: derived from encoder, spindle and observer") \
    X(observer_bandwidth_mHz,      1000,     200000,    5000000, cam_flag_off, "bandwidth of the angle observer, at most tick rate / 12.5") \
    X(lead_ns,                        0,     100000,   20000000, cam_flag_unlearn, "dead time of the U drive, from tick to motion, half a tick of hold included") \
    X(k1_ns,                          0,          0,  100000000, cam_flag_rest | cam_flag_unlearn, "velocity feed-forward of U: 2 damping / natural frequency") \
    X(k2_us2,                         0,          0, 1000000000, cam_flag_rest | cam_flag_unlearn, "acceleration feed-forward of U: 1 / natural frequency squared") \
    X(xz_lag_ns,                      0,          0,  100000000, 0, "lag of the X and Z drives on a ramp, compensated by reading ahead") \
    X(phase_udeg,            -180000000,          0,  180000000, cam_flag_operator | cam_flag_cut, "rotates the shape on the part, by the drawing's angle; ramped") \
    X(phase_rate_udeg_per_s,       1000,    1000000,  100000000, 0, "rate of that ramp") \
    X(amplitude_ppm,                  0,    1000000,    1250000, cam_flag_operator | cam_flag_cut, "scale of U; ramped") \
    X(amplitude_rate_ppm_per_s,    1000,     500000,   10000000, 0, "rate of that ramp") \
    X(engage_turns,                   1,         10,        100, cam_flag_operator, "turns over which amplitude and depth rise") \
    X(disengage_turns,                1,         10,        100, cam_flag_operator, "turns over which they fall") \
    X(feed_ramp_turns,                1,          2,        100, cam_flag_operator, "turns over which the feed rises and falls, for the acceleration of Z") \
    X(u_stroke_nm,                 1000,    1200000,   30000000, cam_flag_rest, "travel of U peak to peak, centred on U = 0") \
    X(u_speed_um_per_s,             100,     400000,   10000000, cam_flag_rest, "highest speed of U") \
    X(u_acceleration_mm_per_s2,     100,     250000,   10000000, cam_flag_rest, "highest acceleration of U") \
    X(u_retract_nm,           -15000000,    -500000,          0, 0, "position of U out of the work, beyond its outermost position in the cut; the default goes as far as the stroke allows") \
    X(x_clearance_nm,                 0,    1000000,  100000000, 0, "X off the part before engaging and after a fault; at least its stock") \
    X(x_speed_um_per_s,             100,     100000,   10000000, 0, "highest speed of X") \
    X(x_acceleration_mm_per_s2,      10,       2000,    1000000, 0, "highest acceleration of X") \
    X(z_speed_um_per_s,             100,     200000,   10000000, 0, "highest speed of Z") \
    X(z_acceleration_mm_per_s2,      10,       2000,    1000000, 0, "highest acceleration of Z") \
    X(z_is_measured,                  0,          0,          1, cam_flag_off, "0: Z is geared to the spindle by the feed; 1: Z is moved by another control and measured") \
    X(z_margin_nm,                    0,     100000,   10000000, 0, "measured Z may leave the table, or a geared Z its set-point, by this much") \
    X(spindle_mrpm,                   0,          0,   60000000, cam_flag_operator, "spindle speed in r/min / 1000; 0: the table's") \
    X(feed_nm,                        0,          0,   10000000, cam_flag_operator, "feed per revolution; 0: the table's") \
    X(spindle_limit_mrpm,          1000,    3000000,   60000000, 0, "highest spindle speed in r/min / 1000") \
    X(spindle_lag_us,                 0,          0,    1000000, 0, "time constant of the spindle's speed loop, compensated while the speed is modulated") \
    X(spindle_acceleration_mrad_per_s2, 1000, 500000, 2000000000, 0, "highest acceleration of the spindle") \
    X(stopped_mrpm,                   1,       5000,    1000000, 0, "the spindle counts as stopped below this speed, in r/min / 1000") \
    X(stopped_ms,                     1,        100,      10000, 0, "a stopped spindle is a fault after this time while cutting") \
    X(following_limit_nm,             0,     100000,   10000000, 0, "accepted following error of U; 0, the default where U is measured at 5 kHz or faster: a tenth of the ovality, not less than the drive may be off in its approach") \
    X(late_percent,                  10,         50,        900, 0, "a tick is late when it comes this much of a period after its time") \
    X(swing_speed_mdeg_per_s,         0,          0,  100000000, 0, "highest speed of the tool's swing; 0: there is no axis for it") \
    X(swing_acceleration_deg_per_s2,  1,     100000,  100000000, 0, "highest acceleration of the swing") \
    X(swing_range_mdeg,               1,      30000,      90000, 0, "the tool swings by at most this to either side") \
    X(swing_lag_ns,                   0,          0,   20000000, 0, "lag of the swing's drive on a ramp, compensated by reading ahead") \
    X(swing_following_limit_mdeg,     1,       1000,      90000, 0, "accepted following error of the swing") \
    X(x_trim_nm,               -1000000,          0,    1000000, cam_flag_operator | cam_flag_cut, "trim of X on the radius, positive away from the axis, for the wear of the tool; half of that of the diameter; ramped") \
    X(pass,                           0,          0,         16, cam_flag_operator, "0: passes in their order, setting it begins with the first; else every start cuts this one") \
    X(rehearse_turns,                 0,          0,       1000, cam_flag_operator, "turns for which the first height is played clear of the work before a cut, to learn; 0: none") \
    X(u_scale_latency_ns,             0,          0,   10000000, cam_flag_unlearn, "age of U's scale reading relative to the encoder's angle") \
    X(u_scale_nm,                     0,         10,      10000, 0, "quantum of U's scale; learning ignores smaller errors") \
    X(learn_harmonics,                0,          0,         16, 0, "harmonics of a turn in which U's error is learned; 0: none") \
    X(learn_gain_ppm,                 0,     500000,     600000, 0, "share of the error that a step of a rehearsal removes") \
    X(learn_cut_gain_ppm,             0,     150000,     200000, 0, "the same in the cut; 0: no learning there") \
    X(probe_nm,                     100,       1000,       5000, 0, "correction at each harmonic by which a rehearsal identifies U's response; at least three steps of the scale") \
    X(ripple_turns,                   0,          0,         64, cam_flag_ripple, "turns whose mean is the learned ripple of the spindle, one counts as two; 0: it is not learned") \
    X(eccentricity_nturn,             0,          0,    1000000, cam_flag_ripple, "amplitude of the encoder's error once per turn") \
    X(eccentricity_udeg,     -180000000,          0,  180000000, cam_flag_ripple, "drawing's angle at which that error is 0 and rises") \
    X(u_jog_um_per_s,                 1,       2000,    1000000, 0, "highest jog speed of U") \
    X(x_jog_um_per_s,                 1,      10000,    1000000, 0, "highest jog speed of X") \
    X(z_jog_um_per_s,                 1,      10000,    1000000, 0, "highest jog speed of Z") \
    X(x_low_nm,             -2000000000,          0, 2000000000, 0, "lower limit of X's travel, in machine coordinates; low = high: none") \
    X(x_high_nm,            -2000000000,          0, 2000000000, 0, "upper limit of it") \
    X(z_low_nm,             -2000000000,          0, 2000000000, 0, "lower limit of Z's travel, in machine coordinates; low = high: none") \
    X(z_high_nm,            -2000000000,          0, 2000000000, 0, "upper limit of it") \
    X(homing_required,                0,          0,          1, 0, "1: enable and start require every axis with a homing method to be homed") \
    X(u_home,                         0,          0,          5, 0, "homing of U: 0 none, its position is known; 1 at its present position; 2 switch; 3 switch and index; of a U that takes forces: 4 stop; 5 stop and index") \
    X(u_home_sense,                  -1,          1,          1, cam_flag_sign, "direction in which U searches its switch or stop, 1: its position rises; 0 is refused") \
    X(u_home_um_per_s,                1,       1000,    1000000, 0, "speed of that search") \
    X(u_home_slow_um_per_s,           1,        100,    1000000, 0, "... off the switch or stop and to the index") \
    X(u_home_nm,              -15000000,          0,   15000000, 0, "U at its home") \
    X(x_home,                         0,          0,          3, 0, "homing of X, as that of U") \
    X(x_home_sense,                  -1,          1,          1, cam_flag_sign, "direction in which X searches its switch, 1: away from the axis; 0 is refused") \
    X(x_home_um_per_s,                1,      10000,    1000000, 0, "speed of that search") \
    X(x_home_slow_um_per_s,           1,       1000,    1000000, 0, "... off the switch and to the index") \
    X(x_home_nm,            -1000000000,          0, 1000000000, 0, "X at its home, in machine coordinates") \
    X(x_home_travel_nm,            1000,  500000000, 2000000000, 0, "the search of X ends without success after this") \
    X(z_home,                         0,          0,          3, 0, "homing of Z, as that of U") \
    X(z_home_sense,                  -1,          1,          1, cam_flag_sign, "direction in which Z searches its switch, 1: its height rises; 0 is refused") \
    X(z_home_um_per_s,                1,      10000,    1000000, 0, "speed of that search") \
    X(z_home_slow_um_per_s,           1,       1000,    1000000, 0, "... off the switch and to the index") \
    X(z_home_nm,            -1000000000,          0, 1000000000, 0, "Z at its home, in machine coordinates") \
    X(z_home_travel_nm,            1000, 1000000000, 2000000000, 0, "the search of Z ends without success after this") \
    X(x_datum_nm,           -1000000000,          0, 1000000000, cam_flag_operator, "X of the part minus X of the machine, with tool 0") \
    X(z_datum_nm,           -1000000000,          0, 1000000000, cam_flag_operator, "height of the part minus Z of the machine, with tool 0") \
    X(tool,                           0,          0,          4, cam_flag_operator, "tool whose offsets apply; 0: none") \
    X(tool_1_x_nm,           -500000000,          0,  500000000, cam_flag_operator, "tip of tool 1 farther from the axis than that of tool 0 by this") \
    X(tool_1_z_nm,           -500000000,          0,  500000000, cam_flag_operator, "... and at a greater height by this") \
    X(tool_2_x_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 2") \
    X(tool_2_z_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 2") \
    X(tool_3_x_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 3") \
    X(tool_3_z_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 3") \
    X(tool_4_x_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 4") \
    X(tool_4_z_nm,           -500000000,          0,  500000000, cam_flag_operator, "the same of tool 4") \
    X(x_trim_limit_nm,                0,     200000,    1000000, 0, "largest trim of X to either side") \
    X(x_trim_rate_nm_per_s,        1000,      20000,     100000, 0, "rate of its ramp") \
    X(feed_override_ppm,              0,    1000000,    1500000, cam_flag_operator | cam_flag_cut | cam_flag_transient, "feed over its programmed value; below 1 %: Z stops, as in a hold; ramped like the feed") \
    X(spindle_override_ppm,      500000,    1000000,    1200000, cam_flag_operator | cam_flag_cut | cam_flag_transient, "speed of the spindle over its programmed value; ramped") \
    X(spindle_override_rate_ppm_per_s, 1000,  50000,    1000000, 0, "rate of that ramp, within spindle_acceleration_mrad_per_s2") \
    X(u_jerk_m_per_s3,                0,          0, 2000000000, cam_flag_rest, "highest jerk of U in timed moves and the retract; a quarter of it in an approach; 0: derived from tick, limits and feed-forward") \
    X(x_jerk_m_per_s3,                0,          0, 2000000000, 0, "the same of X; 0: its acceleration changes over 6.4 ms") \
    X(z_jerk_m_per_s3,                0,          0, 2000000000, 0, "the same of Z; 0: its acceleration changes over 6.4 ms") \
    X(enable_dwell_ms,                0,          0,       5000, 0, "U rests for this time after enable, while its drive takes over; at least one tick") \
    X(u_friction_nm,                  0,          0,     100000, cam_flag_unlearn, "lag of U by friction; in the cut its command leads by this in the direction of motion") \
    X(servo_mass_g,                  10,       1500,     100000, cam_flag_off, "moving mass of a U that takes forces") \
    X(servo_crossover_hz,             0,          0,       5000, cam_flag_off, "crossover of its position loop, at most its pole; 0: no loop, and enable is refused") \
    X(servo_lead_percent,           100,       5000,      20000, cam_flag_off, "pole over zero of the loop's lead") \
    X(servo_pole_hz,                 10,       4000,      40000, cam_flag_off, "pole of the lead, at most a fifth of the tick rate") \
    X(servo_integral_mHz,             0,      40000,    1000000, cam_flag_off, "corner of the integral, at most the crossover") \
    X(servo_notch_hz,                 0,          0,      50000, cam_flag_off, "notch, at most a quarter of the tick rate; 0: none") \
    X(servo_notch_zero_permille,      0,        100,       2000, cam_flag_off, "damping of its zeros, at most that of its poles") \
    X(servo_notch_pole_permille,      1,        700,       2000, cam_flag_off, "damping of its poles") \
    X(servo_force_delay_ns,           0,     150000,     500000, cam_flag_off, "from a tick to its force: output, lag of the amplifier, half a tick of hold") \
    X(servo_drag_mn_s_per_m,          0,          0,   10000000, cam_flag_off, "drag, for the feed-forward of the force") \
    X(servo_friction_mn,              0,          0,     200000, cam_flag_off, "friction, likewise") \
    X(servo_stiffness_n_per_m,        0,          0,  100000000, cam_flag_off, "stiffness of flexures, likewise") \
    X(servo_force_limit_mn,         200,     600000,    4000000, cam_flag_off, "largest force, at most 15 times the continuous one") \
    X(servo_force_rate_n_per_ms,      1,    1000000,    1000000, cam_flag_off, "largest change of the loop's force; the push after a frozen scale ignores it") \
    X(servo_continuous_mn,          200,     300000,    4000000, cam_flag_off, "force allowed for ever") \
    X(servo_thermal_ms,             100,      20000,     200000, cam_flag_off, "thermal time constant of the motor: I2t") \
    X(servo_limited_ms,               1,         20,      10000, cam_flag_off, "the force at its limit is a fault after this time") \
    X(servo_runaway_nm,               0,          0,   10000000, cam_flag_off, "accepted deviation of U from the motion that its force causes; 0: that caused by an unknown force as large as the force limit, at most 50 um") \
    X(u_home_force_mn,              100,      20000,     200000, 0, "largest force while U is homed by its stop; more than friction and flexures there") \
    X(servo_measured,                 0,          0,          1, cam_flag_off, "1: the loop was designed from measurements of this drive; 0: from data sheets, which the controller reports")

/// Beginnings of the names of retired parameters: texts that have them are read, these lines are
/// reported and ignored.
#define CAM_RETIRED_PARAMS(X) X(switch_) X(trace_on)
// clang-format on

/// Flags of a parameter. Without `operator` it is a limit or constant and needs the unlocked level.
/// Without `off` or `cut` it changes in off, ready and manual.
typedef enum {
    cam_flag_operator = 1,   ///< an operator sets it for a part, without the unlocked level
    cam_flag_cut = 2,        ///< it may change in the work, too
    cam_flag_off = 4,        ///< only in off: it shifts the angle, or changes how Z or U is moved
    cam_flag_rest = 8,       ///< only while U rests, so that a new gain or limit causes no step
    cam_flag_unlearn = 16,   ///< its change ends what was learned of U's drive
    cam_flag_ripple = 32,    ///< its change blends the learned ripple anew
    cam_flag_sign = 64,      ///< -1 or 1; 0 is refused
    cam_flag_transient = 128 ///< for an attended part: neither kept nor restored
} cam_flag_t;

/// Index of a parameter, in the order of the list.
typedef enum {
#define CAM_PARAM_ID(name, min, def, max, flags, what) cam_param_##name,
    CAM_PARAMS(CAM_PARAM_ID)
#undef CAM_PARAM_ID
        cam_n_params
} cam_param_id_t;

/// One value each, in the unit of its name.
typedef struct {
#define CAM_PARAM_FIELD(name, min, def, max, flags, what) int32_t name;
    CAM_PARAMS(CAM_PARAM_FIELD)
#undef CAM_PARAM_FIELD
} cam_params_t;

/// Description of a parameter. Its purpose is in the list only, which saves an image 8 KB.
typedef struct {
    const char *name;      ///< with the unit as its last word
    int32_t min, def, max; ///< within the hard limits, if any
    uint8_t flags;         ///< of cam_flag_t
    bool is_hard;          ///< it has hard limits
} cam_param_info_t;

/// @return NULL when id is not a parameter
const cam_param_info_t *cam_param_info(cam_param_id_t id);

bool cam_param_has(cam_param_id_t id, cam_flag_t flag);

/// @return cam_n_params when there is none
cam_param_id_t cam_param_find(const char *name);

/// @return whether a name begins as that of a retired parameter
bool cam_param_is_retired(const char *name);

cam_params_t cam_param_defaults(void);

/// Reset the transient parameters.
void cam_param_forget(cam_params_t *params);

/// Clamp all parameters to their ranges.
void cam_param_fit(cam_params_t *params);

/// Switch learning on: the default from 5 kHz on.
/// @param measures_u  also what needs a measured U, not only the ripple of the spindle
void cam_param_learn(cam_params_t *params, bool measures_u);

int32_t cam_param_get(const cam_params_t *params, cam_param_id_t id); ///< id < cam_n_params

/// @return cam_ok, cam_err_param_id, cam_err_param_range, or cam_err_hard_limit for a parameter
///         with hard limits; *params is unchanged on error
CAM_MUST_USE cam_err_t cam_param_set(cam_params_t *params, cam_param_id_t id, int32_t value);

/// Why a check refuses parameters or a speed, with the numbers.
typedef struct {
    cam_err_t err;        ///< cam_ok: nothing is refused
    cam_param_id_t param; ///< the refused parameter; cam_n_params: none
    int64_t needed;       ///< its value, or what the motion needs; in the unit of the limit
    int64_t limit; ///< in the unit of the parameter or of CAM_ERR_LIMITS; 0 where none is known
    uint32_t speed_mrpm;      ///< [r/min / 1000] the speed that was judged; 0: none
    uint32_t highest_mrpm;    ///< [r/min / 1000] cam_feasible_highest_mrpm()
    uint32_t largest_feed_nm; ///< [nm] cam_feasible_largest_feed_nm()
    uint32_t pass;            ///< number of the pass that was judged; 0: the table has none
} cam_refusal_t;

static inline cam_refusal_t cam_refusal_none(void)
{
    return (cam_refusal_t){.err = cam_ok, .param = cam_n_params};
}

static inline cam_refusal_t cam_refusal_of(cam_err_t err, cam_param_id_t param, int64_t needed,
                                           int64_t limit)
{
    return (cam_refusal_t){.err = err, .param = param, .needed = needed, .limit = limit};
}

/// Parameters as the text that a port stores.
///
///     # camturn parameters, kept by the controller; tools/camctl params changes them
///     version = 12
///     counts_per_turn = 10000
///     ...
///     crc32 = 2774812345
///
/// Parameters are found by name, so an image with other parameters, or in another order, reads the
/// text too. The CRC-32 covers all bytes before its line. The text is TOML, as in files of
/// tools/camctl.

enum {
    cam_param_store_name_bytes = 40, ///< [bytes] of the longest name of a parameter, with its end
    cam_param_store_line_bytes = 64, ///< [bytes] of the longest line
    cam_param_store_most_bytes =
        (cam_n_params + 4) * cam_param_store_line_bytes, ///< [bytes] of the whole text
};

/// Result of reading a text.
typedef struct {
    cam_err_t err;          ///< cam_ok, cam_err_params_none or cam_err_params_damaged
    bool is_torn;           ///< a later save is incomplete
    uint32_t version;       ///< of the parameters
    uint32_t n_retired;     ///< lines with retired parameters
    uint32_t n_unknown;     ///< lines with other parameters unknown to this image
    uint32_t n_unfit;       ///< values out of their range
    uint32_t n_missing;     ///< parameters of this image without a line
    cam_param_id_t unfit;   ///< the first one out of range; cam_n_params: none
    cam_param_id_t missing; ///< the first one missing; cam_n_params: none
    char unknown[cam_param_store_name_bytes]; ///< name of the first unknown one, cut off
} cam_param_store_found_t;

/// @return CRC-32 of the lines `name = value` in the order of CAM_PARAMS, the same in a controller
///         and in a file of tools/camctl
uint32_t cam_param_store_checksum(const cam_params_t *params);

/// @param text  buffer of cam_param_store_most_bytes
/// @return      [bytes] of the text
uint32_t cam_param_store_write(char *text, const cam_params_t *params, uint32_t version);

/// @param params  parameters without a valid line keep their value, all of them if it is damaged
cam_param_store_found_t cam_param_store_read(const hal_params_t *kept, cam_params_t *params);

/// Rights: command over a bus, and the level at which limits may be changed.
///
/// One sender at a time has command. Taking command starts a session, a number that each of the
/// sender's frames carries. After a second without such a frame, command is lost; another sender
/// may also take it over. Both are counted. The session separates senders that follow the rules and
/// shows a former commander that it no longer has command; it does not protect against forged
/// frames.
///
/// Limits, constants and tables change in the unlocked level only. The commander gets it when the
/// key switch is turned on. It ends when the key is turned off, with command, with lock, and after
/// ten minutes. A key left on does not unlock for the next commander.
///
/// A program that calls cam_machine.h directly (simulator, LinuxCNC) is trusted: it has command and
/// is unlocked. Times are counted in ticks.

enum {
    cam_rights_patience_s = 1, ///< command is lost after this without a frame of its session
    cam_rights_level_s = 600,  ///< the level is locked again after this
    cam_rights_most_sender = 254,
};

/// Level: locked, or unlocked by the key switch. The numbers are part of the CAN protocol.
typedef enum { cam_level_locked, cam_level_key } cam_level_t;

/// State; made by cam_rights_init().
typedef struct {
    hal_operator_t port; ///< key switch and button of the port
    uint32_t tick_hz;
    bool is_bus_calling;   ///< the call being handled came over a bus (cam_can.c)
    uint8_t commander;     ///< its sender number; 0: nobody
    uint8_t session;       ///< of the commander, or the last one
    uint32_t heard_tick;   ///< [ticks] of its last frame
    uint32_t n_take_overs; ///< take-overs of command
    uint32_t n_losses;     ///< losses of command
    cam_level_t level;
    uint32_t level_tick; ///< [ticks] when it was unlocked
    bool is_key_on;      ///< key switch at the last poll
} cam_rights_t;

void cam_rights_init(cam_rights_t *r, const hal_operator_t *port, uint32_t tick_hz);

/// @param sender   1 .. cam_rights_most_sender
/// @param is_over  take it over if another sender has it
/// @return cam_ok; cam_err_not_commander if another sender has it; cam_err_frame: sender invalid
CAM_MUST_USE cam_err_t cam_rights_take(cam_rights_t *r, uint8_t sender, bool is_over,
                                       uint32_t tick);

/// Lock the level, too.
void cam_rights_release(cam_rights_t *r);

bool cam_rights_is_commander(const cam_rights_t *r, uint8_t sender, uint8_t session);

void cam_rights_hear(cam_rights_t *r, uint32_t tick);

/// Lock the level; turning the key switch on again unlocks it.
void cam_rights_lock(cam_rights_t *r);

/// Update command and level from time and key switch.
/// @param inputs  hal_in_* of the last tick
/// @return        whether command was lost since the last call
bool cam_rights_poll(cam_rights_t *r, uint32_t inputs, uint32_t tick);

/// @return cam_ok in the unlocked level; else cam_err_locked, or cam_err_lock_none if the port
///         has no key switch
CAM_MUST_USE cam_err_t cam_rights_check_level(const cam_rights_t *r);

/// @return [s] until the level is locked again, rounded up; 0: locked
uint32_t cam_rights_level_left_s(const cam_rights_t *r, uint32_t tick);

enum { cam_text_number_bytes = 21 }; ///< [bytes] longest number with sign and end

/// @param buffer  of cam_text_number_bytes
/// @return        the number in decimal, in the buffer
const char *cam_text_number(char *buffer, int64_t value);

#endif
