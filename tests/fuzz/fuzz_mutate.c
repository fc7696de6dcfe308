// SPDX-License-Identifier: Apache-2.0
#include "fuzz_mutate.h"
#include <stdbool.h> // bool
#include <string.h>  // memcpy, memmove

static uint32_t next(uint32_t *dice)
{
    *dice = *dice * 1664525u + 1013904223u;
    return *dice >> 8;
}

static void change(uint8_t *order, size_t n, uint32_t *dice)
{
    const size_t at = next(dice) % n;
    const uint32_t how = next(dice) % 4u;
    uint32_t value = next(dice);
    if (how == 0u) {
        value = order[at] ^ (UINT32_C(1) << value % 8u);
    } else if (how == 1u) {
        value = order[at] + value % 5u - 2u;
    } else {
        // any byte
    }
    order[at] = (uint8_t)value;
}

static void fill(uint8_t *order, size_t n, uint32_t *dice)
{
    for (size_t i = 0; i < n; i++) {
        order[i] = (uint8_t)next(dice);
    }
}

/// Make room for an order at a place. @return the new size
static size_t open(uint8_t *data, size_t size, size_t at, size_t order)
{
    memmove(data + at + order, data + at, size - at);
    return size + order;
}

static size_t close(uint8_t *data, size_t size, size_t at, size_t order)
{
    memmove(data + at, data + at + order, size - at - order);
    return size - order;
}

static size_t mutate_once(uint8_t *data, size_t size, size_t max_size, uint32_t *dice, size_t head,
                          size_t order)
{
    const size_t n = (size - head) / order;
    const size_t at = head + order * (n > 0u ? next(dice) % n : 0u);
    const size_t from = head + order * (n > 0u ? next(dice) % n : 0u);
    const bool has_room = size + order <= max_size;
    uint8_t copy[16] = {0};
    switch (next(dice) % 6u) {
    case 0: // a new one
        if (has_room) {
            size = open(data, size, at, order);
            fill(data + at, order, dice);
        }
        break;
    case 1: // one of those that are there
        if (has_room && n > 0u) {
            memcpy(copy, data + from, order);
            size = open(data, size, at, order);
            memcpy(data + at, copy, order);
        }
        break;
    case 2:
        if (n > 1u) {
            size = close(data, size, at, order);
        }
        break;
    case 3:
        change(data, head, dice);
        break;
    default:
        if (n > 0u) {
            change(data + at, order, dice);
        }
        break;
    }
    return size;
}

size_t fuzz_mutate_orders(uint8_t *data, size_t size, size_t max_size, unsigned seed, size_t head,
                          size_t order)
{
    uint32_t dice = seed;
    if (size < head + order || next(&dice) % 16u == 0u) {
        return LLVMFuzzerMutate(data, size, max_size);
    }
    for (uint32_t n = next(&dice) % 4u + 1u; n > 0u; n--) {
        size = mutate_once(data, size, max_size, &dice, head, order);
    }
    return size;
}
