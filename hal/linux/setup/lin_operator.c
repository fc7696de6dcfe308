// SPDX-License-Identifier: Apache-2.0
#include "lin_setup.h"
#include <sys/random.h> // getrandom

hal_operator_t lin_operator(const lin_config_t *config)
{
    uint32_t nonce;
    if (getrandom(&nonce, sizeof nonce, GRND_NONBLOCK) != (ssize_t)sizeof nonce) {
        nonce = 0;
    }
    return (hal_operator_t){
        .has_acknowledge = lin_line_is_there(config, lin_line_acknowledge),
        .is_acknowledge_waived = lin_config_is_waived(config),
        .has_key = lin_line_is_there(config, lin_line_key),
        .nonce = nonce,
    };
}
