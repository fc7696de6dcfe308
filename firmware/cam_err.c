// SPDX-License-Identifier: Apache-2.0
#include "cam/cam_err.h"

const char *cam_err_text(cam_err_t err)
{
    switch (err) {
    case cam_ok:
        return "done";
    case cam_err_image_address:
        return "the image is not aligned to 4 bytes";
    case cam_err_image_size:
        return "the image is cut off or has bytes behind its end";
    case cam_err_image_magic:
        return "this is not a cam table";
    case cam_err_image_order:
        return "the table has another byte order";
    case cam_err_image_version:
        return "the table has a version that this firmware does not know";
    case cam_err_image_crc:
        return "the table is damaged: its CRC-32 differs";
    case cam_err_image_header:
        return "a field of the table header is out of its range";
    case cam_err_image_name:
        return "the part name of the table is not printable text";
    case cam_err_image_channel:
        return "a channel of the table is out of its range, twice there or missing";
    case cam_err_image_layout:
        return "a channel of the table lies misaligned, overlapping or outside";
    case cam_err_image_height:
        return "the heights of a channel of the table are inconsistent";
    case cam_err_image_knots:
        return "a knot of the table is beyond the bounds of the evaluation";
    case cam_err_image_limits:
        return "knots of the table exceed the limits that it guarantees";
    case cam_err_param_id:
        return "there is no such parameter";
    case cam_err_param_range:
        return "the value is out of the parameter's range";
    case cam_err_param_state:
        return "this parameter cannot change in this state";
    case cam_err_param_tick:
        return "lead, bandwidth or feed-forward do not fit the tick rate";
    case cam_err_state:
        return "the command is out of order in this state";
    case cam_err_busy:
        return "the previous command is still on its way";
    case cam_err_no_table:
        return "no valid table is selected";
    case cam_err_estop:
        return "the emergency stop is active";
    case cam_err_drive:
        return "the drives are not ready";
    case cam_err_spindle_speed:
        return "the speed is beyond the spindle's limit";
    case cam_err_u_speed:
        return "U would have to move faster than it can";
    case cam_err_u_acceleration:
        return "U would have to accelerate more than it can";
    case cam_err_u_stroke:
        return "U would have to travel farther than it can";
    case cam_err_z_speed:
        return "feed and speed are beyond the speed of Z";
    case cam_err_z_acceleration:
        return "feed, speed and ramp are beyond the acceleration of Z";
    case cam_err_feed:
        return "the feed per turn is larger than the part is high";
    case cam_err_tick_rate:
        return "too many knots or counts pass in one tick";
    }
    return "unknown error";
}
