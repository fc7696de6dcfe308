// SPDX-License-Identifier: Apache-2.0
/// hal_defaults: the functions of hal.h that a port may leave out, without those of the swing. A
/// port's own function has priority. A force that the port states but does not write halts in the
/// first tick that calls it.
#include "hal/hal.h"

#define HAL_DEFAULT __attribute__((weak))

HAL_DEFAULT hal_force_t hal_force(void)
{
    return (hal_force_t){0};
}

HAL_DEFAULT void hal_force_write_isr(int32_t force_q6)
{
    (void)force_q6; // called only where the port states a quantum
    hal_halt("port: hal_force() without hal_force_write_isr()");
}

HAL_DEFAULT bool hal_has_edge_time(void)
{
    return false;
}

HAL_DEFAULT bool hal_measures_u(void)
{
    return false;
}

HAL_DEFAULT hal_axis_scale_t hal_axis_scale(hal_axis_t axis)
{
    (void)axis;
    return (hal_axis_scale_t){0};
}

HAL_DEFAULT hal_memory_t hal_scope_memory(void)
{
    return (hal_memory_t){0};
}

HAL_DEFAULT void hal_scope_keep(const int32_t *words, uint32_t n)
{
    (void)words;
    (void)n;
}

HAL_DEFAULT hal_start_t hal_start(void)
{
    return (hal_start_t){.reset = hal_reset_power_on, .why = ""};
}

HAL_DEFAULT hal_image_t hal_table_image(void)
{
    return (hal_image_t){0};
}

HAL_DEFAULT bool hal_table_begin(uint32_t size)
{
    (void)size;
    return false;
}

HAL_DEFAULT bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    (void)offset;
    (void)bytes;
    (void)n;
    return false;
}

HAL_DEFAULT hal_image_t hal_table_staged(void)
{
    return (hal_image_t){0};
}

HAL_DEFAULT bool hal_table_commit(void)
{
    return false;
}

HAL_DEFAULT hal_params_t hal_params_kept(void)
{
    return (hal_params_t){0};
}

HAL_DEFAULT bool hal_params_keep(const void *bytes, uint32_t size)
{
    (void)bytes;
    (void)size;
    return false;
}

HAL_DEFAULT hal_load_t hal_load(void)
{
    return (hal_load_t){0};
}

HAL_DEFAULT bool hal_can_read(hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}

HAL_DEFAULT bool hal_can_write(const hal_can_frame_t *frame)
{
    (void)frame;
    return false;
}
