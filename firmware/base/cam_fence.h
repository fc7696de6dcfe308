// SPDX-License-Identifier: Apache-2.0
/// cam_fence: memory fences for the interrupt's half of every hand-over to and from the slow side.
///
/// Data is handed over by writing it first and setting an atomic index or counter afterwards. The
/// slow side uses the acquire and release operations of C11 for that; the interrupt uses a relaxed
/// operation and one of these fences. A Cortex-M has one core, on which the interrupt and the slow
/// side see the same memory, so it is enough that the compiler keeps the order there. Everywhere
/// else (the simulator, Linux) the two may run on different cores and the fence is a real one.
#ifndef CAM_FENCE_H
#define CAM_FENCE_H

#include <stdatomic.h> // fences

/// Order of the interrupt's loads and stores of what is handed over. The fences alone would do; the
/// orders cost nothing where there are several cores, and a sanitizer of threads knows no fences.
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define CAM_ORDER_ACQUIRE memory_order_relaxed
#define CAM_ORDER_RELEASE memory_order_relaxed
#else
#define CAM_ORDER_ACQUIRE memory_order_acquire
#define CAM_ORDER_RELEASE memory_order_release
#endif

/// To be called after the relaxed load that shows that something was handed over: what the other
/// side wrote before is visible from here on. Context: ISR.
static inline void cam_fence_acquire_isr(void)
{
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
    atomic_signal_fence(memory_order_acquire);
#else
    atomic_thread_fence(memory_order_acquire);
#endif
}

/// To be called before the relaxed store that hands something over: the other side, once it sees
/// the store, sees all that was written before. Context: ISR.
static inline void cam_fence_release_isr(void)
{
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
    atomic_signal_fence(memory_order_release);
#else
    atomic_thread_fence(memory_order_release);
#endif
}

#endif
