// SPDX-License-Identifier: Apache-2.0
/// cam_hard: limits of parameters that a port's builder fixes when its image is built.
///
/// CMake's CAM_HARD_LIMITS names a header with a list of X(id, name, least, most); id is passed on
/// (example: tests/unit/firmware/param/hard_limits.h). No source, be it the bus, a file or the
/// store, can set a listed parameter outside its range, and its default is clamped to it. The
/// ranges of cam_param.h hold as well. following_limit_nm = 0 derives the limit from the part, so a
/// list that bounds it must begin above 0. Context: build time.
#ifndef CAM_HARD_H
#define CAM_HARD_H

#ifdef CAM_HARD_LIMITS_FILE
#include CAM_HARD_LIMITS_FILE // CAM_HARD_LIMITS
#else
#define CAM_HARD_LIMITS(X, id)
#endif

#define CAM_HARD_IS(id, name, least, most) || (id) == cam_param_##name
#define CAM_HARD_LEAST_OF(id, name, least, most) (id) == cam_param_##name ? (least):
#define CAM_HARD_MOST_OF(id, name, least, most) (id) == cam_param_##name ? (most):

/// Whether a parameter has such limits, and which: constant expressions.
#define CAM_HARD_IS_SET(id) (0 CAM_HARD_LIMITS(CAM_HARD_IS, id))
#define CAM_HARD_LEAST(id) (CAM_HARD_LIMITS(CAM_HARD_LEAST_OF, id) INT32_MIN)
#define CAM_HARD_MOST(id) (CAM_HARD_LIMITS(CAM_HARD_MOST_OF, id) INT32_MAX)

#endif
