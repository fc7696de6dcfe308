// SPDX-License-Identifier: Apache-2.0
#include "cam_err.h"
#include <stddef.h> // size_t

typedef struct {
    cam_err_t err;
    const char *text;
} err_text_t;

static const err_text_t entries[] = {
    {cam_ok, "done"},
    {cam_err_image_address, "the image is not aligned to 4 bytes"},
    {cam_err_image_size, "the image is cut off or has bytes behind its end"},
    {cam_err_image_magic, "this is not a cam table"},
    {cam_err_image_order, "the table has another byte order"},
    {cam_err_image_version, "the table has a version that this firmware does not know"},
    {cam_err_image_crc, "the table is damaged: its CRC-32 differs"},
    {cam_err_image_header, "a field of the table header is out of its range"},
    {cam_err_image_name, "the part name of the table is not printable text"},
    {cam_err_image_channel, "a channel of the table is out of its range, twice there or missing"},
    {cam_err_image_layout, "a channel of the table lies misaligned, overlapping or outside"},
    {cam_err_image_height, "the heights of a channel of the table are inconsistent"},
    {cam_err_image_knots, "a knot of the table is beyond the bounds of the evaluation"},
    {cam_err_image_limits, "knots of the table exceed the limits that it guarantees"},
    {cam_err_param_id, "there is no such parameter"},
    {cam_err_param_range, "the value is out of the parameter's range"},
    {cam_err_param_state, "this parameter cannot change in this state"},
    {cam_err_param_tick, "lead, bandwidth or feed-forward do not fit the tick rate"},
    {cam_err_state, "the command is out of order in this state"},
    {cam_err_busy, "the previous command is still on its way"},
    {cam_err_no_table, "no valid table is selected"},
    {cam_err_estop, "the emergency stop is active"},
    {cam_err_drive, "the drives are not ready"},
    {cam_err_frame, "the command frame has a wrong length or reserved bytes set"},
    {cam_err_command, "there is no such command"},
    {cam_err_u_place, "U stands outside of its stroke: move it by hand or check its zero"},
    {cam_err_bus, "a node on the bus is silent"},
    {cam_err_download_room, "the controller has no room for the table"},
    {cam_err_download_order, "this is not the next block of the download"},
    {cam_err_download_short, "bytes of the download are missing"},
    {cam_err_download_crc, "the download is damaged: its CRC-32 differs"},
    {cam_err_download_store, "the controller could not keep the table"},
    {cam_err_spindle_speed, "the speed is beyond the spindle's limit"},
    {cam_err_u_speed, "U would have to move faster than it can"},
    {cam_err_u_acceleration, "U would have to accelerate more than it can"},
    {cam_err_u_stroke, "U would have to travel farther than it can"},
    {cam_err_z_speed, "feed and speed are beyond the speed of Z"},
    {cam_err_z_acceleration, "feed, speed and ramp are beyond the acceleration of Z"},
    {cam_err_feed, "the feed per turn is larger than the part is high"},
    {cam_err_tick_rate, "too many knots or counts pass in one tick"},
    {cam_err_spindle_acceleration, "the spindle would have to accelerate more than it can"},
    {cam_err_x_speed, "clearance or barrel at that speed are beyond the speed of X"},
    {cam_err_spindle_loop, "the spindle's speed loop is too slow for its modulation"},
    {cam_err_spindle_set_point, "the speed loop would be told more than the highest speed"},
    {cam_err_z_stations, "the table stands at its lobes, which a measured Z cannot do"},
    {cam_err_u_retract, "the retract that was set leaves the stroke of U"},
    {cam_err_x_acceleration, "clearance or barrel at that speed are beyond the acceleration of X"},
    {cam_err_swing_axis, "the table swings the tool, for which there is no axis"},
    {cam_err_swing_range, "the tool would have to swing farther than it can"},
    {cam_err_swing_speed, "the tool would have to swing faster than it can"},
    {cam_err_swing_acceleration, "the swing of the tool would have to accelerate more than it can"},
    {cam_err_scope_field, "there is no such field of the recorder, or it cannot be set"},
    {cam_err_scope_range, "the value is out of the range of the recorder's field"},
    {cam_err_scope_memory, "the memory of the recorder is too small for it"},
    {cam_err_scope_on, "a recording runs"},
    {cam_err_scope_trace, "no ticks are recorded while the parameter trace_on is 0"},
    {cam_err_wave_none, "no complete wave was downloaded"},
    {cam_err_wave_length, "the wave, its fade or the whole of it are too short or too long"},
    {cam_err_wave_stroke, "the wave would lead U out of its stroke"},
    {cam_err_wave_speed, "the wave would move U faster than it can"},
    {cam_err_wave_acceleration, "the wave would accelerate U more than it can"},
    {cam_err_wave_clear, "X is not far enough off the work for the wave of U"},
    {cam_err_scope_unread, "the black box of a fault has not been read yet"},
    {cam_err_scope_before, "more rows are wanted before the trigger than fit"},
    {cam_err_hand_axis, "there is no such axis, or others move it"},
    {cam_err_hand_speed, "the speed is beyond that of the axis by hand"},
    {cam_err_travel, "an axis would leave its travel"},
    {cam_err_hand_moves, "an axis is being moved by hand"},
    {cam_err_home_none, "the axis has no way of homing"},
    {cam_err_not_homed, "an axis is not homed"},
    {cam_err_override_measured, "Z is led by others: there is no feed to hold or to override"},
    {cam_err_override_rings,
     "a ring-helix has no override of the feed, and none of the spindle above 100 %"},
    {cam_err_trim_limit, "the trim of X is beyond x_trim_limit_nm"},
    {cam_err_table_sense, "the table turns in the other sense: disable the drives before"},
    {cam_err_cam_amplitude, "a cam with an amplitude below 1 would be cut deeper than drawn"},
    {cam_err_params_begin, "no change of several parameters was begun"},
    {cam_err_params_stale, "a parameter was set since the change was begun"},
    {cam_err_params_none, "no parameters are kept"},
    {cam_err_params_damaged, "the kept parameters are damaged"},
    {cam_err_params_keep, "the parameters could not be kept"},
    {cam_err_param_output, "the axis would be faster than the port's output passes on"},
    {cam_err_acknowledge, "acknowledge at the machine: since power-on, the emergency stop or a "
                          "fault nobody has pressed its button"},
    {cam_err_acknowledge_none,
     "the port has no input acknowledge, and its builder has not waived it in the port's settings"},
    {cam_err_not_commander, "the sender does not command: take_command first"},
    {cam_err_locked, "locked: turn the key switch, or answer a challenge"},
    {cam_err_lock_none, "locked for good: the port has neither a key switch nor a secret"},
    {cam_err_unlock, "the answer does not belong to the last challenge, which is used up"},
    {cam_err_hard_limit,
     "the value is beyond the limits that the port's builder fixed when its image was built"},
};

const char *cam_err_text(cam_err_t err)
{
    for (size_t i = 0; i < sizeof entries / sizeof entries[0]; i++) {
        if (entries[i].err == err) {
            return entries[i].text;
        }
    }
    return "unknown error";
}
