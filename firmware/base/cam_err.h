// SPDX-License-Identifier: Apache-2.0
/// cam_err: what can go wrong on the slow side, one value each.
///
/// The interrupt returns no errors; it latches faults (cam_guard.h). The numbers are part of the
/// CAN protocol (camturn.dbc): a value keeps its number for good.
#ifndef CAM_ERR_H
#define CAM_ERR_H

/// Result of a slow-side function: 0 or a negative value. The first error found is the one
/// reported.
typedef enum {
    cam_ok = 0,
    // Image (cam_table_check), in the order of the checks
    cam_err_image_address = -1, ///< the image is not aligned to 4 bytes
    cam_err_image_size = -2,    ///< fewer bytes than a header, or not the size given in the header
    cam_err_image_magic = -3,   ///< the image does not begin like a cam table
    cam_err_image_order = -4,   ///< the image is of the other byte order
    cam_err_image_version = -5, ///< the image has a version that this firmware does not know
    cam_err_image_crc = -6,     ///< the image is damaged: its CRC-32 differs
    cam_err_image_header = -7,  ///< a field of the header is out of its range
    cam_err_image_name = -8,    ///< the part name is not printable or not terminated
    cam_err_image_channel = -9, ///< a channel entry is out of its range, twice there or missing
    cam_err_image_layout = -10, ///< a channel lies misaligned, overlapping or outside the image
    cam_err_image_height = -11, ///< the heights of a channel are inconsistent
    cam_err_image_knots = -12,  ///< a knot exceeds the bounds that make overflow impossible
    cam_err_image_limits = -13, ///< the knots exceed the limits that the image guarantees
    // Parameters and commands
    cam_err_param_id = -20,    ///< there is no such parameter
    cam_err_param_range = -21, ///< the value is out of the parameter's range
    cam_err_param_state = -22, ///< the parameter cannot change in this state
    cam_err_param_tick = -23,  ///< lead, bandwidth or feed-forward do not fit the tick rate
    cam_err_state = -24,       ///< the command is not accepted in this state
    cam_err_busy = -25,        ///< the interrupt has not yet taken the previous command
    cam_err_no_table = -26,    ///< no valid table is selected
    cam_err_estop = -27,       ///< the emergency stop is active
    cam_err_drive = -28,       ///< the drives are not ready
    cam_err_frame = -29,       ///< the command frame has a wrong length or reserved bytes set
    cam_err_command = -30,     ///< there is no such command
    cam_err_u_place = -31,     ///< U stands outside of its stroke
    cam_err_bus = -37,         ///< a node on the field bus is silent
    // Download of a table
    cam_err_download_room = -32,  ///< the image is larger than the place for it
    cam_err_download_order = -33, ///< the block is not the next one, or no download was begun
    cam_err_download_short = -34, ///< the download was ended before its last byte
    cam_err_download_crc = -35,   ///< the received bytes are not the sent ones: CRC-32 differs
    cam_err_download_store = -36, ///< the port could not store the image
    // Feasibility: table x speed x machine (cam_feasible.h)
    cam_err_spindle_speed = -40,        ///< the speed exceeds the spindle's limit
    cam_err_u_speed = -41,              ///< U would exceed its highest speed
    cam_err_u_acceleration = -42,       ///< U would exceed its highest acceleration
    cam_err_u_stroke = -43,             ///< U would exceed its stroke
    cam_err_z_speed = -44,              ///< feed x speed exceeds the speed of Z
    cam_err_z_acceleration = -45,       ///< feed x speed squared / ramp exceeds Z's acceleration
    cam_err_feed = -46,                 ///< the feed per turn is larger than the height of the part
    cam_err_tick_rate = -47,            ///< too many knots or encoder counts pass in one tick
    cam_err_spindle_acceleration = -48, ///< the modulation exceeds the spindle's acceleration
    cam_err_x_speed = -49,              ///< clearance or barrel exceed X's speed
    cam_err_x_acceleration = -50,       ///< clearance or barrel exceed X's acceleration
    cam_err_swing_axis = -51,           ///< the table swings the tool, but there is no axis for it
    cam_err_swing_range = -52,          ///< the swing would exceed its range
    cam_err_swing_speed = -53,          ///< the swing would exceed its highest speed
    cam_err_swing_acceleration = -54,   ///< the swing would exceed its highest acceleration
    cam_err_cam_amplitude = -55,        ///< a lobe at an amplitude below 1 is cut deeper than drawn
    cam_err_u_retract = -56,            ///< the retract that was set leaves U's stroke
    cam_err_spindle_loop = -57,         ///< the spindle's speed loop is slower than the modulation
    cam_err_spindle_set_point = -58,    ///< its set-point would exceed the spindle's highest speed
    cam_err_z_stations = -59,           ///< the table counts turns, but others move Z
    // Recorder and excitation (cam_scope.h, cam_machine_identify.h)
    cam_err_scope_field = -60,       ///< there is no such field, or it cannot be set
    cam_err_scope_range = -61,       ///< the value is out of the field's range
    cam_err_scope_memory = -62,      ///< the memory of the recorder is too small
    cam_err_scope_on = -63,          ///< a recording runs
    cam_err_scope_trace = -64,       ///< the parameter trace_on is 0
    cam_err_wave_none = -65,         ///< no complete wave was downloaded
    cam_err_wave_length = -66,       ///< wave, fade or the whole of it are too short or too long
    cam_err_wave_stroke = -67,       ///< U would leave its stroke
    cam_err_wave_speed = -68,        ///< U would exceed its highest speed
    cam_err_wave_acceleration = -69, ///< U would exceed its highest acceleration
    cam_err_wave_clear = -70,        ///< X is so near that U would lead the tool to the work
    // By hand (cam_machine_jog.h)
    cam_err_hand_axis = -71,  ///< there is no such axis, or others move it
    cam_err_hand_speed = -72, ///< the speed exceeds that of the axis by hand
    cam_err_travel = -73,     ///< the axis would leave its travel
    cam_err_hand_moves = -74, ///< an axis is being moved
    cam_err_home_none = -75,  ///< the axis has no way of homing
    cam_err_not_homed = -76,  ///< an axis is not homed
    // Changes while the cut goes on (cam_machine_override.h)
    cam_err_override_measured = -79, ///< others move Z: its feed cannot be overridden or held
    cam_err_override_rings =
        -80,                  ///< a ring-helix has its programmed feed or none, and no higher speed
    cam_err_trim_limit = -81, ///< |x_trim_nm| exceeds x_trim_limit_nm
    cam_err_table_sense = -82, ///< ready, and the next table turns in the other sense
    // Parameters that are kept (cam_machine_params.c)
    cam_err_params_begin = -87,   ///< no change of several parameters was begun
    cam_err_params_stale = -88,   ///< a parameter was set since that change was begun
    cam_err_params_none = -89,    ///< no parameters are kept
    cam_err_params_damaged = -90, ///< the kept parameters are damaged
    cam_err_params_keep = -91,    ///< the port could not keep the parameters
    cam_err_scope_unread = -95,   ///< the black box of a fault has not been read
    cam_err_scope_before = -96,   ///< no row is left behind the trigger
    // Outputs of the port (cam_derived_limits.h)
    cam_err_param_output = -110, ///< the axis would be faster than the port's output passes on
    // Who may command (cam_rights.h, cam_acknowledge.h)
    cam_err_acknowledge = -120,      ///< nobody has acknowledged at the machine
    cam_err_acknowledge_none = -121, ///< the port has no input to acknowledge
    cam_err_not_commander = -122,    ///< another node has command, or nobody
    cam_err_locked = -123,           ///< it needs the unlocked level
    cam_err_lock_none = -124,        ///< it needs the unlocked level, which this port never has
    cam_err_unlock = -125,           ///< the challenge was answered wrong, or none was asked for
    cam_err_hard_limit = -126, ///< the value is beyond the limits that the port's builder fixed
    // Signature of a table (cam_signature_check.h)
    cam_err_sign_none = -130,    ///< it has none, and the port requires one
    cam_err_sign_block = -131,   ///< its block is not one that this firmware knows
    cam_err_sign_key = -132,     ///< it is of a key that the port does not trust
    cam_err_sign_wrong = -133,   ///< it is not of these bytes
    cam_err_sign_no_keys = -134, ///< the port requires one, but names no key
    // Motions by time and what the feed-forward adds to them (cam_gains.h)
    cam_err_gain = -135, ///< the feed-forward would tell U more than its limits allow
    cam_err_jerk = -136, ///< a jerk that small takes a longer window than there is
    // How long a cut may be (cam_feasible.h)
    cam_err_turns = -137, ///< the part has more turns of feed than the controller counts
} cam_err_t;

/// The compiler refuses a call that ignores the result of such a function.
#define CAM_MUST_USE __attribute__((warn_unused_result))

/// @return one English clause without a full stop, static; "unknown error" for a foreign value
/// Context: slow side.
const char *cam_err_text(cam_err_t err);

#endif
