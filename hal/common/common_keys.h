// SPDX-License-Identifier: Apache-2.0
/// common_keys: public keys that a builder writes in a file or on a command line, for hal_trust().
#ifndef COMMON_KEYS_H
#define COMMON_KEYS_H

#include <stdbool.h> // bool
#include <stdint.h>  // uint8_t, uint32_t

enum {
    common_keys_most = 4,   ///< two for a rotation, twice
    common_keys_bytes = 32, ///< of a public key of Ed25519
    common_keys_digits = 2 * common_keys_bytes,
};

/// What a message adds when common_keys_add() refuses.
#define COMMON_KEYS_REMEDY                                                                         \
    "give public keys as tools/keys show prints them, 64 digits each, none of them weak, at most " \
    "4"

/// Keys, one behind the other. Zero-initialised: none.
typedef struct {
    uint8_t bytes[common_keys_most * common_keys_bytes];
    uint32_t n;
} common_keys_t;

/// Add the keys of a text: 64 hexadecimal digits each, with blanks, commas or line ends between.
/// @return false when the text holds something else, a point of small order as key, for which
///         anybody can make up signatures, or more keys than there is room for; the keys are then
///         as before
bool common_keys_add(common_keys_t *keys, const char *text);

#endif
