// SPDX-License-Identifier: Apache-2.0
/// stm_params: the log in flash in which parameters are kept over a restart (hal_params_*()).
#ifndef STM_PARAMS_H
#define STM_PARAMS_H

/// Find the record that counts. Context: slow side, once, before hal_params_kept().
void stm_params_init(void);

#endif
