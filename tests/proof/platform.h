// SPDX-License-Identifier: Apache-2.0
/// stdatomic for Frama-C, which knows no _Atomic: the operations as a single thread sees them.
///
/// What two threads make of the order of these operations is beyond this proof; README.md says so.
#ifndef PROOF_STDATOMIC_H
#define PROOF_STDATOMIC_H

#include <stdint.h> // int32_t, uint32_t
#include <string.h> // memcpy

#define __builtin_memcpy memcpy
#define __FC_STDATOMIC // the header of Frama-C, which gives no meaning to these operations, is
                       // empty
#define _Atomic
#define memory_order_relaxed 0
#define memory_order_acquire 1
#define memory_order_release 2
#define memory_order_acq_rel 3

#define atomic_load_explicit(object, order) (*(object))
#define atomic_store_explicit(object, value, order) ((void)(*(object) = (value)))
#define atomic_thread_fence(order) ((void)0)
#define atomic_signal_fence(order) ((void)0)

/// What ACSL says of a right shift and WP does not know: it is the quotient rounded down. C leaves
/// that of negative numbers to the compiler; cam_fix.h asserts it of each that compiles it.
/*@ axiomatic shift {
      axiom down_1: \forall integer v; 2 * (v >> 1) <= v <= 2 * (v >> 1) + 1;
      axiom down_2: \forall integer v; 4 * (v >> 2) <= v <= 4 * (v >> 2) + 3;
      axiom down_4: \forall integer v; 16 * (v >> 4) <= v <= 16 * (v >> 4) + 15;
      axiom down_24: \forall integer v; (v >> 24) * 0x1000000 <= v < ((v >> 24) + 1) * 0x1000000;
      axiom one: \forall integer n; 0 <= n <= 61 ==> 1 <= (1 << n) <= 0x2000000000000000;
      axiom down_32: \forall integer v;
        (v >> 32) * 0x100000000 <= v < ((v >> 32) + 1) * 0x100000000;
    }
*/

/// What C says of conversions to an unsigned word, and GCC and Clang of those to a signed one: they
/// are modulo 2^32, or 2^64. WP knows it of values that fit only.
/// A product of unsigned words is the same modulo 2^32, whichever of the numbers that are alike a
/// factor stands for.
/*@ axiomatic word {
      axiom unsigned_below: \forall integer v;
        -0x100000000 <= v < 0 ==> (uint32_t)v == v + 0x100000000;
      axiom unsigned_above: \forall integer v;
        0x100000000 <= v < 0x200000000 ==> (uint32_t)v == v - 0x100000000;
      axiom signed_below: \forall integer v;
        -0x100000000 <= v < -0x80000000 ==> (int32_t)v == v + 0x100000000;
      axiom signed_above: \forall integer v;
        0x80000000 <= v < 0x180000000 ==> (int32_t)v == v - 0x100000000;
      axiom signed_far: \forall integer v;
        0x180000000 <= v < 0x200000000 ==> (int32_t)v == v - 0x200000000;
      axiom product: \forall integer v, b; (int32_t)((uint32_t)v * b) == (int32_t)(v * b);
      axiom unsigned_long_below: \forall integer v;
        -0x10000000000000000 <= v < 0 ==> (uint64_t)v == v + 0x10000000000000000;
      axiom unsigned_long_above: \forall integer v;
        0x10000000000000000 <= v < 0x20000000000000000 ==> (uint64_t)v == v - 0x10000000000000000;
      axiom signed_long_above: \forall integer v;
        0x8000000000000000 <= v < 0x10000000000000000 ==> (int64_t)v == v - 0x10000000000000000;
    }
*/

#endif
