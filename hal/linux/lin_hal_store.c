// SPDX-License-Identifier: Apache-2.0
/// Functions of hal.h for tables, parameters and black box. File errors are reported by hal_text().
#include "hal/hal.h"
#include "lin_setup.h"

static void report(const common_error_t *e)
{
    if (e->text[0] != '\0') {
        hal_text(e->text);
    }
}

hal_image_t hal_table_image(void)
{
    return lin_table_image();
}

bool hal_table_begin(uint32_t size)
{
    return lin_table_begin(size);
}

bool hal_table_write(uint32_t offset, const void *bytes, uint32_t n)
{
    return lin_table_write(offset, bytes, n);
}

hal_image_t hal_table_staged(void)
{
    return lin_table_staged();
}

bool hal_table_commit(void)
{
    common_error_t e;
    const bool is_stored = lin_table_commit(&e);
    report(&e);
    return is_stored;
}

hal_params_t hal_params_kept(void)
{
    return lin_params_kept();
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    common_error_t e;
    const bool is_stored = lin_params_keep(bytes, size, &e);
    report(&e);
    return is_stored;
}

hal_memory_t hal_scope_memory(void)
{
    return lin_blackbox_memory();
}

void hal_scope_keep(const int32_t *words, uint32_t n)
{
    common_error_t e;
    lin_blackbox_keep(words, n, &e);
    report(&e);
}
