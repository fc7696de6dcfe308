// SPDX-License-Identifier: Apache-2.0
/// cam_offsets: homes, datum and tools: where the part lies on the machine, and the machine on the
/// numbers of the port.
///
///     X of the machine = X of the port + shift       found by homing, 0 before
///     X of the part    = X of the machine + datum + offset of the tool
///
/// and likewise Z. U is moved to its home by the interrupt itself. Source: MATHS.md (170). Context:
/// slow side, cannot fail.
#ifndef CAM_OFFSETS_H
#define CAM_OFFSETS_H

#include "cam_param.h"  // cam_params_t
#include "cam_status.h" // cam_status_t
#include <stdbool.h>    // bool
#include <stdint.h>     // int32_t, uint32_t

/// State; zero-initialised nothing was ordered and nothing is homed.
typedef struct {
    uint32_t serial;             ///< of the newest order
    uint32_t n_found;            ///< homes that the configuration in force knows
    bool has_searched_u;         ///< U's numbers have changed by a search since the start
    uint32_t known;              ///< bit of an axis: its home was found since the start
    int32_t home_nm[hal_n_axes]; ///< [nm] where the port counted it there
} cam_offsets_t;

/// How an axis is homed and moved by hand, from the parameters. What U has not is 0.
typedef struct {
    int32_t method; ///< 0: its place is known, 1: where it stands, 2: switch, 3: switch and index
    int32_t sense;
    int32_t search_um_per_s, slow_um_per_s;
    int32_t home_nm;           ///< [nm] by the machine
    int32_t way_nm;            ///< [nm] that a phase of homing may take
    int32_t low_nm, high_nm;   ///< [nm] travel by the machine; low >= high: none
    int32_t datum_nm, tool_nm; ///< [nm] datum, and offset of the tool that counts
} cam_offsets_axis_t;

/// @return what the parameters say of an axis
cam_offsets_axis_t cam_offsets_axis(const cam_params_t *params, hal_axis_t axis);

/// @return [nm] the machine's number less the port's; of U 0
int32_t cam_offsets_shift_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// @return [nm] where the port counts 0 of the part, saturated; of U 0
int32_t cam_offsets_origin_nm(const cam_offsets_t *h, const cam_params_t *params, hal_axis_t axis);

/// [nm] travel of an axis without limits, to either side; beyond 2^30 nm the controller stops it.
#define CAM_OFFSETS_FAR_NM 1073000000

/// Travel of an axis in the numbers of the port.
typedef struct {
    int32_t low_nm, high_nm;
} cam_offsets_travel_t;

/// @param axis      X or Z
/// @param is_known  whether its place is; if not, nothing is known of its travel
cam_offsets_travel_t cam_offsets_travel(const cam_offsets_t *h, const cam_params_t *params,
                                        hal_axis_t axis, bool is_known);

/// @return whether the place of an axis is known: nothing is to be homed, or its home was found and
///         not forgotten
bool cam_offsets_is_known(const cam_params_t *params, const cam_status_t *status, hal_axis_t axis);

#endif
