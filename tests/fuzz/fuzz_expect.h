// SPDX-License-Identifier: Apache-2.0
/// fuzz_expect: what ends a target when an invariant does not hold.
#ifndef FUZZ_EXPECT_H
#define FUZZ_EXPECT_H

#include <stdint.h> // uint8_t
#include <stdio.h>  // fprintf
#include <stdlib.h> // abort
#include <stddef.h> // size_t

/// One input. libFuzzer calls it, and so does fuzz_replay.c. @return 0
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// End the program with a line that shows the broken invariant and its numbers. The line goes to
/// stdout, because the targets turn off the firmware's own lines of text, which go to stderr.
#define FUZZ_EXPECT(is_good, ...)                                                                  \
    do {                                                                                           \
        if (!(is_good)) {                                                                          \
            (void)printf("%s:%d: broken: %s: ", __FILE__, __LINE__, #is_good);                     \
            (void)printf(__VA_ARGS__);                                                             \
            (void)printf("\n");                                                                    \
            (void)fflush(stdout);                                                                  \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

#endif
