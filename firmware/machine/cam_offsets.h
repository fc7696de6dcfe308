// SPDX-License-Identifier: Apache-2.0
/// cam_offsets: port coordinates to machine coordinates to part coordinates, for X and Z.
///
///     machine = port + shift                         from homing, 0 before
///     part    = machine + datum + tool offset
///
/// The interrupt itself shifts U. Source: MATHS.md (170). Context: slow side, cannot fail.
#ifndef CAM_OFFSETS_H
#define CAM_OFFSETS_H

#include "cam_param.h"  // cam_params_t
#include "cam_status.h" // cam_status_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised: no order, no home.
typedef struct {
    uint32_t serial;             ///< of the newest order
    uint32_t n_found;            ///< homings applied to the configuration in force
    bool has_searched_u;         ///< a search of U's home was ordered since the start
    uint32_t known;              ///< one bit per axis: homed since the start
    int32_t home_nm[hal_n_axes]; ///< [nm] the home, in port coordinates
} cam_offsets_t;

/// Parameters of an axis. Fields that do not apply to U are 0.
typedef struct {
    int32_t method; ///< of homing; 0: none needed, 1: as it stands, 2: switch, 3: switch and index,
                    ///< 4: stop, 5: stop and index
    int32_t sense;
    int32_t search_um_per_s, slow_um_per_s;
    int32_t home_nm;           ///< [nm] machine coordinate
    int32_t way_nm;            ///< [nm] longest travel of a homing phase
    int32_t low_nm, high_nm;   ///< [nm] travel, machine coordinates; equal: no limits
    int32_t datum_nm, tool_nm; ///< [nm] datum, and offset of the selected tool
} cam_offsets_axis_t;

/// @return the parameters of an axis
cam_offsets_axis_t cam_offsets_axis(const cam_params_t *params, hal_axis_t axis);

/// @return [nm] machine coordinate minus port coordinate; 0 for U
int32_t cam_offsets_shift_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// @return [nm] port coordinate of the part's zero, saturated; 0 for U
int32_t cam_offsets_origin_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// [nm] travel to either side of an axis without limits; readings beyond 2^30 nm are refused.
#define CAM_OFFSETS_FAR_NM 1000000000

/// Travel of an axis, in port coordinates.
typedef struct {
    int32_t low_nm, high_nm;
} cam_offsets_travel_t;

/// @param axis      X or Z
/// @param is_known  whether its position is known; otherwise the limits do not apply
cam_offsets_travel_t cam_offsets_travel(const cam_offsets_t *h, const cam_params_t *params,
                                        hal_axis_t axis, bool is_known);

/// @return whether the position of an axis is known: homed, or no homing needed
bool cam_offsets_is_known(const cam_params_t *params, const cam_status_t *status, hal_axis_t axis);

#endif
