// SPDX-License-Identifier: Apache-2.0
/// stm_table: two places for tables in flash, and a log of which one is in use.
#ifndef STM_TABLE_H
#define STM_TABLE_H

/// Read the log of which place is in use. Context: slow side, once, before hal_table_image().
void stm_table_init(void);

#endif
