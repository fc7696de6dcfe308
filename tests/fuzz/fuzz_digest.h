// SPDX-License-Identifier: Apache-2.0
/// fuzz_digest: a number that sums up what an input leads to, so that a replay sees every change of
/// what the firmware does.
#ifndef FUZZ_DIGEST_H
#define FUZZ_DIGEST_H

#include <stddef.h> // size_t
#include <stdint.h> // int64_t

/// Begin the digest of an input.
void fuzz_digest_begin(void);

/// Add a value: an output, an answer, a member of the state.
void fuzz_note(int64_t value);

/// Add words of 32 bits, such as the members of a struct.
void fuzz_note_words(const void *words, size_t n_bytes);

/// @return the digest since its begin
uint64_t fuzz_digest(void);

#endif
