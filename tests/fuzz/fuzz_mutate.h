// SPDX-License-Identifier: Apache-2.0
/// fuzz_mutate: mutators that know how an input is built. libFuzzer and fuzz_replay.c call them
/// through a target's LLVMFuzzerCustomMutator().
#ifndef FUZZ_MUTATE_H
#define FUZZ_MUTATE_H

#include <stddef.h> // size_t
#include <stdint.h> // uint8_t

/// libFuzzer's own mutations; without it fuzz_replay.c changes some bytes.
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

/// A target may define it; fuzz_replay.c has a default.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);

/// Change an input that is a head and orders of equal length: an order is inserted, removed,
/// repeated, moved or changed; now and then libFuzzer's own mutations take the whole of it.
size_t fuzz_mutate_orders(uint8_t *data, size_t size, size_t max_size, unsigned seed, size_t head,
                          size_t order);

#endif
