// SPDX-License-Identifier: Apache-2.0
#include "cam_machine_inner.h"
#include "cam_fix.h" // cam_clamp_i64, cam_sat_i32

cam_offsets_axis_t cam_offsets_axis(const cam_params_t *params, hal_axis_t axis)
{
    const cam_params_t *p = params;
    if (axis == hal_axis_x) {
        const int32_t tool_nm[] = {0, p->tool_1_x_nm, p->tool_2_x_nm, p->tool_3_x_nm,
                                   p->tool_4_x_nm};
        return (cam_offsets_axis_t){
            p->x_home,     p->x_home_sense,     p->x_home_um_per_s, p->x_home_slow_um_per_s,
            p->x_home_nm,  p->x_home_travel_nm, p->x_low_nm,        p->x_high_nm,
            p->x_datum_nm, tool_nm[p->tool]};
    }
    if (axis == hal_axis_z) {
        const int32_t tool_nm[] = {0, p->tool_1_z_nm, p->tool_2_z_nm, p->tool_3_z_nm,
                                   p->tool_4_z_nm};
        return (cam_offsets_axis_t){
            p->z_home,     p->z_home_sense,     p->z_home_um_per_s, p->z_home_slow_um_per_s,
            p->z_home_nm,  p->z_home_travel_nm, p->z_low_nm,        p->z_high_nm,
            p->z_datum_nm, tool_nm[p->tool]};
    }
    return (cam_offsets_axis_t){.method = p->u_home,
                                .sense = p->u_home_sense,
                                .search_um_per_s = p->u_home_um_per_s,
                                .slow_um_per_s = p->u_home_slow_um_per_s,
                                .home_nm = p->u_home_nm,
                                .way_nm = p->u_stroke_nm};
}

int32_t cam_offsets_shift_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis)
{
    const bool is_found = (h->known >> (uint32_t)axis & 1u) != 0u;
    const cam_offsets_axis_t a = cam_offsets_axis(params, axis);
    if (axis == hal_axis_u || !is_found || a.method == 0) {
        return 0;
    }
    return cam_sat_i32((int64_t)a.home_nm - h->home_nm[axis]);
}

int32_t cam_offsets_origin_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis)
{
    const cam_offsets_axis_t a = cam_offsets_axis(params, axis);
    const int64_t part_nm = (int64_t)a.datum_nm + a.tool_nm;
    return cam_sat_i32(-part_nm - cam_offsets_shift_nm(h, params, axis));
}

cam_offsets_travel_t cam_offsets_travel(const cam_offsets_t *h, const cam_params_t *params,
                                        hal_axis_t axis, bool is_known)
{
    const cam_offsets_axis_t a = cam_offsets_axis(params, axis);
    if (a.low_nm == a.high_nm || !is_known) {
        return (cam_offsets_travel_t){-CAM_OFFSETS_FAR_NM, CAM_OFFSETS_FAR_NM};
    }
    const bool is_swapped = a.low_nm > a.high_nm; // limits hold in either order
    const int64_t low_nm = is_swapped ? a.high_nm : a.low_nm;
    const int64_t high_nm = is_swapped ? a.low_nm : a.high_nm;
    const int64_t shift_nm = cam_offsets_shift_nm(h, params, axis);
    return (cam_offsets_travel_t){
        (int32_t)cam_clamp_i64(low_nm - shift_nm, -CAM_OFFSETS_FAR_NM, CAM_OFFSETS_FAR_NM),
        (int32_t)cam_clamp_i64(high_nm - shift_nm, -CAM_OFFSETS_FAR_NM, CAM_OFFSETS_FAR_NM)};
}

bool cam_offsets_is_known(const cam_params_t *params, const cam_status_t *status, hal_axis_t axis)
{
    const bool is_homed = (status->jog.homed >> (uint32_t)axis & 1u) != 0u;
    return is_homed || cam_offsets_axis(params, axis).method == 0;
}
