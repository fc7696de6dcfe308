// SPDX-License-Identifier: Apache-2.0
/// common_keys: public keys from a file or command line, for hal_trust().
#ifndef COMMON_KEYS_H
#define COMMON_KEYS_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint8_t, uint32_t

enum {
    common_keys_most = 4,   ///< two signers, each with an old and a new key
    common_keys_bytes = 32, ///< Ed25519 public key
    common_keys_digits = 2 * common_keys_bytes,
};

/// Remedy for the error message when common_keys_add() returns false.
#define COMMON_KEYS_REMEDY                                                                         \
    "give public keys as tools/keys show prints them, 64 digits each, none of them weak, at most " \
    "4"

/// Keys, concatenated. Zero-initialised: none.
typedef struct {
    uint8_t bytes[common_keys_most * common_keys_bytes];
    uint32_t n;
} common_keys_t;

/// Add keys from text: 64 hexadecimal digits each, separated by blanks, commas or line ends.
/// @return false if the text contains anything else, a weak key (a point of small order, for which
///         anybody can forge signatures) or too many keys; the keys are then unchanged
bool common_keys_add(common_keys_t *keys, const char *text);

#endif
