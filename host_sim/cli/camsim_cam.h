// SPDX-License-Identifier: Apache-2.0
/// camsim_cam: what the summary of a cut tells of a cam.
#ifndef CAMSIM_CAM_H
#define CAMSIM_CAM_H

#include "camsim.h" // camsim_options_t
#include <cjson/cJSON.h>

/// @return true when the table is that of a cam
bool camsim_cam_is(const sim_cut_t *cut);

/// @return false and *e when an option has no meaning for a cam
bool camsim_cam_check(const camsim_options_t *options, const sim_cut_t *cut, sim_error_t *e);

/// Add "cam": lobes, surface speed, effective rake. Nothing is added for a skirt, nor for a cam
/// without its report: then the gauge compares X - U with the table.
void camsim_cam_json(cJSON *root, const sim_cut_t *cut);

/// Print the same to standard output.
void camsim_cam_text(const sim_cut_t *cut);

#endif
