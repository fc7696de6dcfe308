// SPDX-License-Identifier: Apache-2.0
/// stm_params: flash log that keeps parameters across a restart (hal_params_*()).
#ifndef STM_PARAMS_H
#define STM_PARAMS_H

/// Find the current record. Context: slow side, once, before hal_params_kept().
void stm_params_init(void);

#endif
