// SPDX-License-Identifier: Apache-2.0
/// lin_operator: what [operator] of the configuration says of the people at the machine: button,
/// key switch, secret.
#ifndef LIN_OPERATOR_H
#define LIN_OPERATOR_H

#include "common_error.h" // common_error_t
#include "hal/hal.h"      // hal_operator_t
#include "lin_config.h"   // lin_config_t
#include <stdbool.h>      // bool

/// Read the secret, if there is one, and noise for its challenges. The file is a regular one that
/// nobody but its owner may read or write, 16 to 64 bytes; line ends behind them do not count.
/// @return false and *e: there is a file, but no secret in it. Context: main(), once.
bool lin_operator_open(const lin_config_t *config, common_error_t *e);

/// @return what hal_operator() says
hal_operator_t lin_operator(const lin_config_t *config);

#endif
