// SPDX-License-Identifier: Apache-2.0
/// fuzz_image: inputs that are table images. Nothing gets beyond a wrong CRC, so the mutator
/// repairs it, and the sizes that must be right with it.
#ifndef FUZZ_IMAGE_H
#define FUZZ_IMAGE_H

#include <stddef.h> // size_t
#include <stdint.h> // uint8_t

/// Change an image by libFuzzer's mutations, or a whole word of it, and make its CRC right, which
/// one time in sixteen is left as it is.
/// @param head  [bytes] in front of the image, which no CRC covers
size_t fuzz_image_mutate(uint8_t *data, size_t size, size_t max_size, unsigned seed, size_t head);

#endif
