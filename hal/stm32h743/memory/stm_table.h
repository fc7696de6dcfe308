// SPDX-License-Identifier: Apache-2.0
/// stm_table: two places for tables in flash, and a log that records which one is in use.
#ifndef STM_TABLE_H
#define STM_TABLE_H

#include <stdbool.h> // bool

/// Read the log. Context: slow side, once, before hal_table_image().
void stm_table_init(void);

/// @return whether the table in use is lost: older firmware stored it where code is now.
/// Context: slow side.
bool stm_table_is_lost(void);

#endif
