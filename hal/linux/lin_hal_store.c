// SPDX-License-Identifier: Apache-2.0
/// The functions of hal.h for what is kept over a restart: tables, parameters, black box. What goes
/// wrong with a file is told in a line of text.
#include "hal/hal.h"
#include "lin_blackbox.h"
#include "lin_params.h"
#include "lin_table.h"

static void tell(const common_error_t *e)
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
    tell(&e);
    return is_stored;
}

hal_params_t hal_params_kept(void)
{
    return lin_params_kept();
}

bool hal_params_keep(const void *bytes, uint32_t size)
{
    common_error_t e;
    const bool is_kept = lin_params_keep(bytes, size, &e);
    tell(&e);
    return is_kept;
}

hal_memory_t hal_scope_memory(void)
{
    return lin_blackbox_memory();
}

void hal_scope_keep(const int32_t *words, uint32_t n)
{
    common_error_t e;
    lin_blackbox_keep(words, n, &e);
    tell(&e);
}
