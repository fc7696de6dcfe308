// SPDX-License-Identifier: Apache-2.0
/// fuzz_digest: one number for all values that a target notes while it runs an input; fuzz_replay.c
/// and the campaign's hours compare it with a record.
#ifndef FUZZ_DIGEST_H
#define FUZZ_DIGEST_H

#include <stdbool.h> // bool
#include <stddef.h>  // size_t
#include <stdint.h>  // int64_t

/// Begin the digest of an input.
void fuzz_digest_begin(void);

/// Add a value: an output, an answer, a member of the state.
void fuzz_note(int64_t value);

/// Add a struct without padding, 32 bits at a time; a rest below four bytes is not added.
void fuzz_note_words(const void *words, size_t n_bytes);

/// @return the digest since its begin
uint64_t fuzz_digest(void);

/// Compare a sum of digests with a record, and print the line that it lacks.
/// @param path   of the record, a file of lines "NAME DIGEST"
/// @return whether the sum is that of the name
bool fuzz_digest_is_recorded(const char *path, const char *name, uint64_t sum);

#endif
