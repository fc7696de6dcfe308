// SPDX-License-Identifier: Apache-2.0
/// stm_table: two places for tables in flash, and a log that records which one is in use.
#ifndef STM_TABLE_H
#define STM_TABLE_H

#include <stdbool.h> // bool

/// Read the log. Context: slow side, once, before hal_table_image().
void stm_table_init(void);

/// @return whether the table in use was in a place that an older firmware used and where code is
/// now: it is no longer there. Context: slow side.
bool stm_table_is_lost(void);

#endif
