// SPDX-License-Identifier: Apache-2.0
#include "cam_param.h"
#include "cam_fix.h" // cam_clamp_i32
#include <stddef.h>  // NULL, offsetof
#include <string.h>  // memcpy, strcmp, strlen, strncmp

// Hard limits, see cam_param.h.
#ifdef CAM_HARD_LIMITS_FILE
#include CAM_HARD_LIMITS_FILE // CAM_HARD_LIMITS
#else
#define CAM_HARD_LIMITS(X, id)
#endif

#define CAM_HARD_IS(id, name, least, most) || (id) == cam_param_##name
#define CAM_HARD_LEAST_OF(id, name, least, most) (id) == cam_param_##name ? (least):
#define CAM_HARD_MOST_OF(id, name, least, most) (id) == cam_param_##name ? (most):

// Whether a parameter has such limits, and which: constant expressions.
#define CAM_HARD_IS_SET(id) (0 CAM_HARD_LIMITS(CAM_HARD_IS, id))
#define CAM_HARD_LEAST(id) (CAM_HARD_LIMITS(CAM_HARD_LEAST_OF, id) INT32_MIN)
#define CAM_HARD_MOST(id) (CAM_HARD_LIMITS(CAM_HARD_MOST_OF, id) INT32_MAX)

/// Ranges and defaults of the list, within the hard limits.
#define MOST_OF(a, b) ((a) > (b) ? (a) : (b))
#define LEAST_OF(a, b) ((a) < (b) ? (a) : (b))
#define PARAM_MIN(name, min) MOST_OF(min, CAM_HARD_LEAST(cam_param_##name))
#define PARAM_MAX(name, max) LEAST_OF(max, CAM_HARD_MOST(cam_param_##name))
#define PARAM_DEF(name, min, def, max)                                                             \
    LEAST_OF(MOST_OF(def, PARAM_MIN(name, min)), PARAM_MAX(name, max))

#define PARAM_INFO(name, min, def, max, flags, what)                                               \
    {#name,                                                                                        \
     PARAM_MIN(name, min),                                                                         \
     PARAM_DEF(name, min, def, max),                                                               \
     PARAM_MAX(name, max),                                                                         \
     flags,                                                                                        \
     CAM_HARD_IS_SET(cam_param_##name)},
static const cam_param_info_t infos[cam_n_params] = {CAM_PARAMS(PARAM_INFO)};

/// All fields are int32 in the order of the list, so the index of a parameter gives its offset.
#define PARAM_CHECK(name, min, def, max, flags, what)                                              \
    _Static_assert(PARAM_MIN(name, min) <= PARAM_MAX(name, max),                                   \
                   #name ": CAM_HARD_LIMITS leaves no value of its range");                        \
    _Static_assert(offsetof(cam_params_t, name) ==                                                 \
                       (size_t)cam_param_##name * sizeof(((cam_params_t *)NULL)->name),            \
                   #name ": out of its order");
CAM_PARAMS(PARAM_CHECK)

static void assign(cam_params_t *params, uint32_t id, int32_t value)
{
    (void)memcpy((char *)params + (size_t)id * sizeof value, &value, sizeof value);
}

const cam_param_info_t *cam_param_info(cam_param_id_t id)
{
    return (unsigned)id < cam_n_params ? &infos[id] : NULL;
}

bool cam_param_has(cam_param_id_t id, cam_flag_t flag)
{
    const cam_param_info_t *info = cam_param_info(id);
    return info != NULL && ((uint32_t)info->flags & (uint32_t)flag) != 0u;
}

cam_param_id_t cam_param_find(const char *name)
{
    unsigned id = 0;
    while (id < cam_n_params && strcmp(infos[id].name, name) != 0) {
        id++;
    }
    return (cam_param_id_t)id;
}

#define RETIRED_NAME(start) #start,

bool cam_param_is_retired(const char *name)
{
    static const char *const retired[] = {CAM_RETIRED_PARAMS(RETIRED_NAME)};
    bool is_retired = false;
    for (uint32_t i = 0; i < sizeof retired / sizeof retired[0]; i++) {
        is_retired = is_retired || strncmp(name, retired[i], strlen(retired[i])) == 0;
    }
    return is_retired;
}

cam_params_t cam_param_defaults(void)
{
    cam_params_t params = {0};
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        assign(&params, id, infos[id].def);
    }
    return params;
}

void cam_param_learn(cam_params_t *params, bool measures_u)
{
    params->ripple_turns = 8;
    if (!measures_u) {
        return;
    }
    params->feed_ramp_turns = 60;            // the chip's force changes as slowly as it is learned
    params->observer_bandwidth_mHz = 100000; // a learned ripple needs no fast observer
    params->rehearse_turns = 40;
    params->learn_harmonics = 16;
    cam_param_fit(params);
}

void cam_param_forget(cam_params_t *params)
{
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        if (cam_param_has((cam_param_id_t)id, cam_flag_transient)) {
            assign(params, id, infos[id].def);
        }
    }
}

void cam_param_fit(cam_params_t *params)
{
    for (uint32_t id = 0; id < (uint32_t)cam_n_params; id++) {
        const int32_t value = cam_param_get(params, (cam_param_id_t)id);
        assign(params, id, cam_clamp_i32(value, infos[id].min, infos[id].max));
    }
}

int32_t cam_param_get(const cam_params_t *params, cam_param_id_t id)
{
    int32_t value = 0;
    (void)memcpy(&value, (const char *)params + (size_t)id * sizeof value, sizeof value);
    return value;
}

cam_err_t cam_param_set(cam_params_t *params, cam_param_id_t id, int32_t value)
{
    const cam_param_info_t *info = cam_param_info(id);
    if (info == NULL) {
        return cam_err_param_id;
    }
    const bool is_no_sign = value == 0 && cam_param_has(id, cam_flag_sign);
    if (value < info->min || value > info->max || is_no_sign) {
        return info->is_hard ? cam_err_hard_limit : cam_err_param_range;
    }
    assign(params, (uint32_t)id, value);
    return cam_ok;
}

const char *cam_text_number(char *buffer, int64_t value)
{
    static const char digits[] = "0123456789";
    uint32_t at = (uint32_t)cam_text_number_bytes - 1u;
    uint64_t left = value < 0 ? 0u - (uint64_t)value : (uint64_t)value;
    buffer[at] = '\0';
    do {
        at--;
        buffer[at] = digits[left % 10u];
        left /= 10u;
    } while (left > 0u);
    if (value < 0) {
        at--;
        buffer[at] = '-';
    }
    return &buffer[at];
}
