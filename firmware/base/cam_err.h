// SPDX-License-Identifier: Apache-2.0
/// cam_err: what can go wrong on the slow side, one value each.
/// The interrupt returns no errors; it latches faults (cam_guard.h).
#ifndef CAM_ERR_H
#define CAM_ERR_H

/// Result of a slow-side function: 0 or a negative value. The first error wins.
typedef enum {
    cam_ok = 0,
    // image (cam_table_check), in the order of the checks
    cam_err_image_address = -1, ///< image not aligned to 4 bytes
    cam_err_image_size = -2,  ///< fewer bytes than a header, or not the size that the header tells
    cam_err_image_magic = -3, ///< not a cam table
    cam_err_image_order = -4, ///< another byte order
    cam_err_image_version = -5, ///< a version that this firmware does not know
    cam_err_image_crc = -6,     ///< damaged: CRC-32 differs
    cam_err_image_header = -7,  ///< a header field out of its range
    cam_err_image_name = -8,    ///< part name not printable or not terminated
    cam_err_image_channel = -9, ///< a channel entry out of its range, twice or missing
    cam_err_image_layout = -10, ///< channel data misaligned, overlapping or outside the image
    cam_err_image_height = -11, ///< heights of a channel inconsistent
    cam_err_image_knots = -12,  ///< a knot beyond the bounds that make overflow impossible
    cam_err_image_limits = -13, ///< knots beyond the limits that the image guarantees
    // parameters and commands
    cam_err_param_id = -20,    ///< no such parameter
    cam_err_param_range = -21, ///< parameter value out of its range
    cam_err_param_state = -22, ///< parameter cannot change in this state
    cam_err_param_tick = -23,  ///< parameters do not fit the tick rate
    cam_err_state = -24,       ///< command out of order
    cam_err_busy = -25,        ///< the interrupt has not yet taken the previous command
    cam_err_no_table = -26,    ///< no valid table selected
    cam_err_estop = -27,       ///< emergency stop is active
    cam_err_drive = -28,       ///< drives are not ready
    cam_err_frame = -29,       ///< command frame of a wrong length or with reserved bytes set
    cam_err_command = -30,     ///< no such command
    cam_err_u_place = -31,     ///< U stands outside of its stroke
    cam_err_bus = -37,         ///< a node on the bus is silent
    // download of a table
    cam_err_download_room = -32,  ///< larger than the place for it
    cam_err_download_order = -33, ///< a block that is not the next one, or none was begun
    cam_err_download_short = -34, ///< ended before its last byte
    cam_err_download_crc = -35,   ///< other bytes than were meant: CRC-32 differs
    cam_err_download_store = -36, ///< the port could not keep it
    // feasibility: table x speed x machine
    cam_err_spindle_speed = -40,        ///< beyond the spindle's highest speed
    cam_err_u_speed = -41,              ///< U would have to move faster than it can
    cam_err_u_acceleration = -42,       ///< U would have to accelerate more than it can
    cam_err_u_stroke = -43,             ///< U would have to travel farther than it can
    cam_err_z_speed = -44,              ///< feed x speed beyond Z's speed
    cam_err_z_acceleration = -45,       ///< feed x speed squared / ramp beyond Z's acceleration
    cam_err_feed = -46,                 ///< feed per turn larger than the height of the part
    cam_err_tick_rate = -47,            ///< too many knots or encoder counts pass in one tick
    cam_err_spindle_acceleration = -48, ///< modulation beyond the spindle's acceleration
    cam_err_x_speed = -49,              ///< clearance or barrel at that speed beyond X's speed
    cam_err_x_acceleration = -50,       ///< ... beyond X's acceleration
    cam_err_swing_axis = -51,           ///< the table swings the tool: there is no axis for it
    cam_err_swing_range = -52,          ///< the tool would have to swing farther than it can
    cam_err_swing_speed = -53,          ///< ... faster
    cam_err_swing_acceleration = -54,   ///< ... with more acceleration
    cam_err_cam_amplitude = -55,        ///< a cam of less than its lift is cut deeper than drawn
} cam_err_t;

#define CAM_MUST_USE __attribute__((warn_unused_result))

/// @return one English clause without a full stop, static; "unknown error" for a foreign value
const char *cam_err_text(cam_err_t err);

#endif
