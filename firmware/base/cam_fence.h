// SPDX-License-Identifier: Apache-2.0
/// cam_fence: memory fences for the interrupt's side of every hand-over to and from the slow side.
///
/// The writer writes the data first and then sets an atomic index or counter. The slow side uses
/// C11 acquire and release operations; the interrupt uses a relaxed operation and one of these
/// fences. On a Cortex-M both sides run on one core, so keeping the compiler's order is enough.
/// Elsewhere (simulator, Linux) they may run on different cores, and the fence is a real one.
#ifndef CAM_FENCE_H
#define CAM_FENCE_H

#include <stdatomic.h> // fences

/// Memory order of the interrupt's own atomic loads and stores. The fences alone would do, but a
/// thread sanitizer does not understand fences, and with several cores the orders cost nothing.
#if defined(__ARM_ARCH_PROFILE) && __ARM_ARCH_PROFILE == 'M'
#define CAM_ORDER_ACQUIRE memory_order_relaxed
#define CAM_ORDER_RELEASE memory_order_relaxed
#define CAM_FENCE atomic_signal_fence
#else
#define CAM_ORDER_ACQUIRE memory_order_acquire
#define CAM_ORDER_RELEASE memory_order_release
#define CAM_FENCE atomic_thread_fence
#endif

/// Call after the load that shows a hand-over: from here on all earlier writes are visible.
static inline void cam_fence_acquire_isr(void)
{
    CAM_FENCE(memory_order_acquire);
}

/// Call before the store that hands over: a side that sees the store also sees all earlier writes.
static inline void cam_fence_release_isr(void)
{
    CAM_FENCE(memory_order_release);
}

#endif
