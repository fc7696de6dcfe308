// SPDX-License-Identifier: Apache-2.0
/// lin_operator: section [operator] of the configuration: button, key switch, secret.
#ifndef LIN_OPERATOR_H
#define LIN_OPERATOR_H

#include "common_error.h" // common_error_t
#include "hal/hal.h"      // hal_operator_t
#include "lin_config.h"   // lin_config_t
#include <stdbool.h>      // bool

/// Read the secret, if configured, and random bytes for its challenges. The secret is a regular
/// file that only its owner may access, 16 to 64 bytes without trailing line ends.
/// @return false and *e: the file cannot be used. Context: main(), once.
bool lin_operator_open(const lin_config_t *config, common_error_t *e);

/// @return the result of hal_operator()
hal_operator_t lin_operator(const lin_config_t *config);

#endif
