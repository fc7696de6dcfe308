// SPDX-License-Identifier: Apache-2.0
/// cam_err: errors of the slow side. The interrupt returns none; it latches faults (cam_state.h).
#ifndef CAM_ERR_H
#define CAM_ERR_H

#include <stdint.h> // int32_t

// clang-format off
/// X(name, number, text). The numbers are part of the CAN protocol (camturn.dbc): a number is never
/// changed or used again; those from -130 to -134 were of signed tables. A text is one clause without
/// a full stop.
#define CAM_ERRORS(X) \
    /* Image (cam_table_check), in the order of the checks */ \
    X(image_address,          -1, "the image is not aligned to 4 bytes") \
    X(image_size,             -2, "the image is cut off or too long (a signature?): make the table again") \
    X(image_magic,            -3, "this is not a cam table") \
    X(image_order,            -4, "the table has another byte order") \
    X(image_version,          -5, "this firmware does not know the version of the table") \
    X(image_crc,              -6, "the table is damaged: its CRC-32 differs") \
    X(image_header,           -7, "a field of the table header is out of its range") \
    X(image_name,             -8, "the part name of the table is not printable text") \
    X(image_channel,          -9, "a channel of the table is out of its range, duplicated or missing") \
    X(image_layout,          -10, "a channel of the table is misaligned, overlapping or outside the image") \
    X(image_height,          -11, "the heights of a channel of the table are inconsistent") \
    X(image_knots,           -12, "a knot of the table exceeds the bounds of the evaluation") \
    X(image_limits,          -13, "knots of the table exceed the limits that it guarantees") \
    /* Parameters and commands */ \
    X(param_id,              -20, "there is no such parameter") \
    X(param_range,           -21, "the value is out of the parameter's range") \
    X(param_state,           -22, "this parameter cannot change in this state") \
    X(param_tick,            -23, "lead, bandwidth or feed-forward do not fit the tick rate") \
    X(state,                 -24, "the command is not allowed in this state") \
    X(busy,                  -25, "not yet: the last command or change is in progress, U is moving, or the spindle is too fast") \
    X(no_table,              -26, "no valid table is selected") \
    X(estop,                 -27, "the emergency stop is active") \
    X(drive,                 -28, "the drives are not ready") \
    X(frame,                 -29, "the command frame has a wrong length or reserved bytes set") \
    X(command,               -30, "there is no such command") \
    X(u_place,               -31, "U is outside its stroke: jog it back or check its zero") \
    X(bus,                   -37, "a node on the bus is silent") \
    /* Download of a table */ \
    X(download_room,         -32, "the controller has no room for the table") \
    X(download_order,        -33, "this is not the next block of the download") \
    X(download_short,        -34, "bytes of the download are missing") \
    X(download_crc,          -35, "the download is damaged: its CRC-32 differs") \
    X(download_store,        -36, "the controller could not store the table") \
    /* Feasibility: table x speed x machine (cam_feasible.h) */ \
    X(spindle_speed,         -40, "the speed is beyond the spindle's limit") \
    X(u_speed,               -41, "U would have to move faster than it can") \
    X(u_acceleration,        -42, "U would have to accelerate more than it can") \
    X(u_stroke,              -43, "U would have to travel farther than it can") \
    X(z_speed,               -44, "feed and speed are beyond the speed of Z") \
    X(z_acceleration,        -45, "feed, speed and ramp are beyond the acceleration of Z") \
    X(feed,                  -46, "the feed per turn exceeds the height of the part") \
    X(tick_rate,             -47, "too many knots or counts pass in one tick") \
    X(spindle_acceleration,  -48, "the spindle would have to accelerate more than it can") \
    X(x_speed,               -49, "clearance or barrel at that speed are beyond the speed of X") \
    X(x_acceleration,        -50, "clearance or barrel at that speed are beyond the acceleration of X") \
    X(swing_axis,            -51, "the table swings the tool, for which there is no axis") \
    X(swing_range,           -52, "the tool would have to swing farther than it can") \
    X(swing_speed,           -53, "the tool would have to swing faster than it can") \
    X(swing_acceleration,    -54, "the swing of the tool would have to accelerate more than it can") \
    X(cam_amplitude,         -55, "a lobe with an amplitude below 1 would be cut deeper than drawn") \
    X(u_retract,             -56, "the retract position is outside U's stroke") \
    X(spindle_loop,          -57, "the spindle's speed loop is too slow for its modulation") \
    X(spindle_set_point,     -58, "the set-point of the speed loop would exceed the highest speed") \
    X(z_stations,            -59, "the table stops Z at its lobes or lands, which a measured Z cannot do") \
    /* Recorder and excitation (cam_recorder.h, cam_machine.h) */ \
    X(scope_field,           -60, "there is no such field of the recorder, or it is read-only") \
    X(scope_range,           -61, "the value is out of the range of the recorder's field") \
    X(scope_memory,          -62, "the memory of the recorder is too small for it") \
    X(scope_on,              -63, "a recording is running") \
    X(wave_none,             -65, "no complete wave was downloaded") \
    X(wave_length,           -66, "the wave, its fade or the whole excitation is too short or too long") \
    X(wave_stroke,           -67, "the wave would move U out of its stroke") \
    X(wave_speed,            -68, "the wave would move U faster than it can") \
    X(wave_acceleration,     -69, "the wave would accelerate U more than it can") \
    X(wave_clear,            -70, "X is not far enough off the work for the wave of U") \
    /* Jogging and homing (cam_machine.h) */ \
    X(hand_axis,             -71, "there is no such axis, or the controller does not move it") \
    X(hand_speed,            -72, "the speed exceeds the axis's jog speed") \
    X(travel,                -73, "an axis would leave its travel") \
    X(hand_moves,            -74, "an axis is being jogged or homed") \
    X(home_none,             -75, "the axis has no homing method, or one that its drive cannot do") \
    X(not_homed,             -76, "an axis is not homed") \
    /* Changes while a part is cut (cam_machine.h) */ \
    X(override_measured,     -79, "Z is measured, not geared: there is no feed to hold or to override") \
    X(override_rings,        -80, "a ring-helix has no override of the feed, and none of the spindle above 100 %") \
    X(trim_limit,            -81, "the trim of X is beyond x_trim_limit_nm") \
    X(table_sense,           -82, "the table turns in the other sense: disable the drives first") \
    /* Stored parameters (cam_machine_params.c) */ \
    X(params_begin,          -87, "no change of several parameters was begun") \
    X(params_stale,          -88, "a parameter was set after the change was begun") \
    X(params_none,           -89, "no parameters are kept") \
    X(params_damaged,        -90, "the kept parameters are damaged") \
    X(params_keep,           -91, "the parameters could not be kept") \
    X(scope_unread,          -95, "the black box of a fault has not been read yet") \
    X(scope_before,          -96, "more rows are requested before the trigger than fit") \
    /* Outputs of the port (cam_feasible.h) */ \
    X(param_output,         -110, "the axis would be faster than the port's output allows") \
    /* Command and level (cam_param.h, cam_plan.h) */ \
    X(acknowledge,          -120, "press the acknowledge button at the machine: required after power-on, " \
                                  "emergency stop or fault") \
    X(acknowledge_none,     -121, "the port has no input acknowledge, and its builder has not waived it in the " \
                                  "port's settings") \
    X(not_commander,        -122, "the sender does not have command: take_command first") \
    X(locked,               -123, "locked: turn the key switch") \
    X(lock_none,            -124, "locked for good: the port has no key switch") \
    X(hard_limit,           -126, "the value exceeds the limits that the port's builder fixed when its image was built") \
    /* Timed moves, their feed-forward, and the length of a cut (cam_feasible.h) */ \
    X(gain,                 -135, "the command to U, feed-forward included, would exceed its limits") \
    X(jerk,                 -136, "the jerk is so small that its window does not fit") \
    X(turns,                -137, "the feed is so small that the part has too many turns") \
    X(u_command,            -138, "the feed-forward would command U beyond its stroke") \
    X(u_command_speed,      -139, "the feed-forward would command U faster than its limits allow") \
    X(u_command_acceleration, -140, "the feed-forward would command U to accelerate too much") \
    /* Position loop of U (cam_feasible.h) */ \
    X(servo_none,           -141, "U takes forces, but its position loop is not set: tools/tune designs it") \
    X(servo,                -142, "a parameter of U's position loop is beyond its bound by the others") \
    X(servo_force,          -143, "acceleration, speed and stroke of U would take more than the force limit") \
    X(wave_unit,            -144, "U takes positions, so no wave of force can be played") \
    X(wave_force,           -145, "the wave exceeds the force limit of U") \
    X(servo_continuous,     -146, "U would need more force for long than its continuous one")

/// X(error, unit, per_unit, parameter): refusals that camctl explains by demand and limit (others:
/// ../README.md, "How to change it"): the unit for people, how many units of the controller make
/// one, and the parameter that gives the limit, or `none`. The limit of a stroke is half of it.
#define CAM_ERR_LIMITS(X) \
    X(spindle_speed,          "r/min",         1000, spindle_limit_mrpm) \
    X(u_speed,                "mm/s",          1000, u_speed_um_per_s) \
    X(u_acceleration,         "mm/s2",            1, u_acceleration_mm_per_s2) \
    X(u_stroke,               "mm",         1000000, u_stroke_nm) \
    X(u_retract,              "mm",         1000000, u_stroke_nm) \
    X(u_command,              "mm",         1000000, u_stroke_nm) \
    X(u_command_speed,        "mm/s",          1000, none) \
    X(u_command_acceleration, "mm/s2",            1, none) \
    X(servo_continuous,       "N rms",         1000, servo_continuous_mn) \
    X(servo_force,            "N",             1000, servo_force_limit_mn) \
    X(z_speed,                "mm/s",          1000, z_speed_um_per_s) \
    X(z_acceleration,         "mm/s2",            1, z_acceleration_mm_per_s2) \
    X(x_speed,                "mm/s",          1000, x_speed_um_per_s) \
    X(x_acceleration,         "mm/s2",            1, x_acceleration_mm_per_s2) \
    X(feed,                   "mm",         1000000, none) \
    X(turns,                  "turns",            1, none) \
    X(tick_rate,              "r/min",         1000, none) \
    X(spindle_acceleration,   "rad/s2",        1000, spindle_acceleration_mrad_per_s2) \
    X(spindle_loop,           "rad/s",         1000, none) \
    X(spindle_set_point,      "r/min",         1000, spindle_limit_mrpm) \
    X(swing_axis,             "swing axis",       1, none) \
    X(swing_range,            "degrees",       1000, swing_range_mdeg) \
    X(swing_speed,            "degrees/s",     1000, swing_speed_mdeg_per_s) \
    X(swing_acceleration,     "degrees/s2",       1, swing_acceleration_deg_per_s2) \
    X(cam_amplitude,          "%",            10000, amplitude_ppm) \
    X(trim_limit,             "mm",         1000000, x_trim_limit_nm)
// clang-format on

/// Result of a slow-side function: 0 or a negative value. The first error found is reported.
typedef enum {
    cam_ok = 0,
#define CAM_ERR_NUMBER(name, number, text) cam_err_##name = (number),
    CAM_ERRORS(CAM_ERR_NUMBER)
#undef CAM_ERR_NUMBER
} cam_err_t;

/// Result of a command or check, with a number for the operator.
typedef struct {
    cam_err_t err;
    int32_t value; ///< the accepted value, or the limit or demand that led to the refusal
} cam_verdict_t;

/// The compiler refuses a call that ignores the result of such a function.
#define CAM_MUST_USE __attribute__((warn_unused_result))

/// @return the text of an error, static; "unknown error" for any other value. Context: slow side.
const char *cam_err_text(cam_err_t err);

#endif
