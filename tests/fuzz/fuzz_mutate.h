// SPDX-License-Identifier: Apache-2.0
/// fuzz_mutate: mutators that know how an input is built. libFuzzer calls them by way of a target's
/// LLVMFuzzerCustomMutator(); what runs inputs again (fuzz_replay.c) never does.
#ifndef FUZZ_MUTATE_H
#define FUZZ_MUTATE_H

#include <stddef.h> // size_t
#include <stdint.h> // uint8_t

/// libFuzzer's own mutations; in a build without it the input stays as it is.
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

/// Called by libFuzzer where a target defines it.
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);

/// Change an input that is a head and orders of equal length: an order is inserted, removed,
/// repeated, moved or changed; now and then libFuzzer's own mutations take the whole of it.
size_t fuzz_mutate_orders(uint8_t *data, size_t size, size_t max_size, unsigned seed, size_t head,
                          size_t order);

#endif
