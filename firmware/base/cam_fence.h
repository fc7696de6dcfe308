// SPDX-License-Identifier: Apache-2.0
/// cam_fence: the interrupt's half of every hand-over to and from the slow side.
///
/// The slow side uses acquire and release operations of C11. A Cortex-M has one core, on which the
/// interrupt and the slow side see the same memory: there it is enough that the compiler keeps the
/// order. Everywhere else (the simulator, Linux) the fence is a real one.
#ifndef CAM_FENCE_H
#define CAM_FENCE_H

#include <stdatomic.h> // fences

/// Behind the relaxed load that tells that something was handed over.
static inline void cam_fence_acquire_isr(void)
{
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
    atomic_signal_fence(memory_order_acquire);
#else
    atomic_thread_fence(memory_order_acquire);
#endif
}

/// In front of the relaxed store that hands something over.
static inline void cam_fence_release_isr(void)
{
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
    atomic_signal_fence(memory_order_release);
#else
    atomic_thread_fence(memory_order_release);
#endif
}

#endif
