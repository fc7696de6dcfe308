// SPDX-License-Identifier: Apache-2.0
/// cam_fix: arithmetic of both sides, inline: fixed point, angles, and the fences between the
/// sides.
///
/// Read the operations on numbers first, then the two kinds of angles, last the fences.
///
/// `_q<n>` in a name gives the number of fraction bits: 0.5 in q28 is 2^27. Right shifts of
/// negative numbers are arithmetic (asserted below), so they round towards minus infinity. Left
/// shifts of signed values are written as multiplications and sums that wrap by design are computed
/// in uint32, because C11 leaves both undefined for signed operands. Names in brackets are single
/// instructions of Cortex-M4/M7: ARMv7-M Architecture Reference Manual, A7.7. Context of all
/// functions: ISR or slow side, constant time, unless noted.
#ifndef CAM_FIX_H
#define CAM_FIX_H

#include <stdatomic.h> // fences
#include <stdbool.h>   // bool
#include <stdint.h>    // int32_t, int64_t, uint32_t

_Static_assert((-3 >> 1) == -2, "arithmetic right shift");

/// The product that the next two functions round to nearest.
//@ logic integer cam_part(integer a, integer b) = (a * b + 0x80000000) >> 32;

/// Multiply by a fraction of 2^-32 and add, with rounding (SMMLAR).
/// @return c + floor(a * b / 2^32 + 1/2) modulo 2^32, any arguments
/*@ assigns \result \from a, b, c;
    ensures exact: INT32_MIN <= c + cam_part(a, b) <= INT32_MAX ==>
      \result == c + cam_part(a, b);
*/
static inline int32_t cam_mulhi_add(int32_t c, int32_t a, int32_t b)
{
#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP
    int32_t sum;
    __asm("smmlar %0, %1, %2, %3" : "=r"(sum) : "r"(a), "r"(b), "r"(c));
    return sum;
#else
    const int64_t product = ((int64_t)a * b + (INT64_C(1) << 31)) >> 32;
    return (int32_t)((uint32_t)c + (uint32_t)(int32_t)product);
#endif
}

/// Multiply by a fraction of 2^-32, rounded to nearest (SMMULR).
/// @return floor(a * b / 2^32 + 1/2), any arguments
/*@ assigns \result \from a, b;
    ensures exact: \result == cam_part(a, b);
*/
static inline int32_t cam_mulhi(int32_t a, int32_t b)
{
#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP
    int32_t product;
    __asm("smmulr %0, %1, %2" : "=r"(product) : "r"(a), "r"(b));
    return product;
#else
    return cam_mulhi_add(0, a, b);
#endif
}

/// @return v limited to the range of int32
/*@ assigns \result \from v;
    ensures inside: INT32_MIN <= v <= INT32_MAX ==> \result == v;
    ensures low: v < INT32_MIN ==> \result == INT32_MIN;
    ensures high: v > INT32_MAX ==> \result == INT32_MAX;
*/
static inline int32_t cam_sat_i32(int64_t v)
{
    const int32_t low = (int32_t)v; // v fits when its sign-extended low word equals v
    return low == v ? low : v < 0 ? INT32_MIN : INT32_MAX;
}

/// @return a + b limited to the range of int32 (QADD)
/*@ assigns \result \from a, b;
    ensures inside: INT32_MIN <= a + b <= INT32_MAX ==> \result == a + b;
    ensures low: a + b < INT32_MIN ==> \result == INT32_MIN;
    ensures high: a + b > INT32_MAX ==> \result == INT32_MAX;
*/
static inline int32_t cam_sat_add(int32_t a, int32_t b)
{
#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP
    int32_t sum;
    __asm("qadd %0, %1, %2" : "=r"(sum) : "r"(a), "r"(b));
    return sum;
#else
    return cam_sat_i32((int64_t)a + b);
#endif
}

/// @return a - b limited to the range of int32 (QSUB)
/*@ assigns \result \from a, b;
    ensures inside: INT32_MIN <= a - b <= INT32_MAX ==> \result == a - b;
    ensures low: a - b < INT32_MIN ==> \result == INT32_MIN;
    ensures high: a - b > INT32_MAX ==> \result == INT32_MAX;
*/
static inline int32_t cam_sat_sub(int32_t a, int32_t b)
{
#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP
    int32_t difference;
    __asm("qsub %0, %1, %2" : "=r"(difference) : "r"(a), "r"(b));
    return difference;
#else
    return cam_sat_i32((int64_t)a - b);
#endif
}

/// @param a, b  two int16 each, the first one in the lower half
/// @return      products of the upper halves and of the lower halves, added modulo 2^32 (SMUAD)
//@ assigns \result \from a, b;
static inline int32_t cam_dot_i16(uint32_t a, uint32_t b)
{
#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP
    int32_t sum;
    __asm("smuad %0, %1, %2" : "=r"(sum) : "r"(a), "r"(b));
    return sum;
#else
    const int32_t a_low = (int16_t)(uint16_t)a;
    const int32_t b_low = (int16_t)(uint16_t)b;
    const int32_t a_high = (int16_t)(uint16_t)(a >> 16);
    const int32_t b_high = (int16_t)(uint16_t)(b >> 16);
    return (int32_t)((uint32_t)(a_low * b_low) + (uint32_t)(a_high * b_high));
#endif
}

/// @return floor(a * b / 2^32), any arguments
/*@ assigns \result \from a, b;
    ensures floor: \result * 0x100000000 <= a * b < (\result + 1) * 0x100000000;
*/
static inline uint32_t cam_mulhi_u32(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32);
}

/// @return a * b / 2^n rounded to nearest, half up; 1 <= n <= 62; the product must fit int32
/*@ requires 1 <= n <= 62;
    requires fits: a * b + (1 << (n - 1)) <= INT64_MAX;
    assigns \result \from a, b, n;
    ensures exact: \result == (int32_t)((a * b + (1 << (n - 1))) >> n);
*/
static inline int32_t cam_mul_shift(int32_t a, int32_t b, uint32_t n)
{
    return (int32_t)(((int64_t)a * b + ((int64_t)1 << (n - 1u))) >> n);
}

/// Shift 64 bits by a run-time count. The compiler's own 64-bit shift handles counts up to 63 and
/// takes twice as many instructions on a Cortex-M.
/// @param n  1 .. 31
/// @return   the low 32 bits of floor(v / 2^n), exact when the result fits int32
/*@ requires 1 <= n <= 31;
    assigns \result \from v, n;
*/
static inline int32_t cam_shift_right(int64_t v, uint32_t n)
{
    const uint32_t low = (uint32_t)(uint64_t)v >> n;
    const uint32_t high = (uint32_t)((uint64_t)v >> 32) << (32u - n);
    return (int32_t)(low | high);
}

/// @return v limited to [lo, hi]
/*@ assigns \result \from v, lo, hi;
    ensures inside: lo <= v <= hi ==> \result == v;
    ensures low: v < lo ==> \result == lo;
    ensures high: v > hi && v >= lo ==> \result == hi;
*/
static inline int32_t cam_clamp_i32(int32_t v, int32_t lo, int32_t hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/// @return v limited to [lo, hi]
/*@ assigns \result \from v, lo, hi;
    ensures inside: lo <= v <= hi ==> \result == v;
    ensures low: v < lo ==> \result == lo;
    ensures high: v > hi && v >= lo ==> \result == hi;
*/
static inline int64_t cam_clamp_i64(int64_t v, int64_t lo, int64_t hi)
{
    return v < lo ? lo : v > hi ? hi : v;
}

/// @return |v|; any v but INT64_MIN
/*@ requires v > INT64_MIN;
    assigns \result \from v;
    ensures \result == \abs(v);
*/
static inline int64_t cam_abs_i64(int64_t v)
{
    return v < 0 ? -v : v;
}

/// @return the smaller of two
static inline int64_t cam_smaller_i64(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/// @return the greater of two
static inline uint64_t cam_greater_u64(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/// @return a / b, rounded up, b above 0. Context: slow side.
//@ requires b > 0;
static inline uint64_t cam_divided_up_u64(uint64_t a, uint64_t b)
{
    return (a + b - 1u) / b;
}

/// @return a * b / c, rounded up, saturated, c above 0. Context: slow side.
//@ requires c > 0;
static inline uint64_t cam_scaled_up_u64(uint64_t a, uint64_t b, uint64_t c)
{
    return a == 0u || b < (uint64_t)INT64_MAX / a ? cam_divided_up_u64(a * b, c)
                                                  : (uint64_t)INT64_MAX;
}

/// @return square root of any v, rounded down. Context: slow side.
//@ assigns \result \from v;
static inline uint64_t cam_root_u64(uint64_t v)
{
    uint64_t r = 0;
    //@ loop assigns bit, r;
    for (uint64_t bit = UINT64_C(1) << 31; bit != 0u; bit >>= 1) {
        r = (r + bit) * (r + bit) <= v ? r + bit : r;
    }
    return r;
}

/// @return a - b of a counter or angle that wraps at 2^32: -2^31 .. 2^31 - 1, by the shorter arc
/*@ assigns \result \from a, b;
    ensures plain: INT32_MIN <= a - b <= INT32_MAX ==> \result == a - b;
    ensures wrapped: \result == a - b || \abs(\result - (a - b)) == 0x100000000;
*/
static inline int32_t cam_wrap_diff(uint32_t a, uint32_t b)
{
    return (int32_t)(a - b);
}

/// @param by  0 .. 2^31 - 1
/// @return    v * by modulo 2^32
/*@ requires by <= INT32_MAX;
    assigns \result \from v, by;
    ensures plain: INT32_MIN <= v * by <= INT32_MAX ==> \result == v * by;
*/
static inline int32_t cam_wrap_times(int32_t v, uint32_t by)
{
    return (int32_t)((uint32_t)v * by);
}

/// @return a + b modulo 2^32
/*@ assigns \result \from a, b;
    ensures plain: INT32_MIN <= a + b <= INT32_MAX ==> \result == a + b;
    ensures wrapped: \result == a + b || \abs(\result - (a + b)) == 0x100000000;
*/
static inline int32_t cam_wrap_add(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

/// @return a - b modulo 2^32
/*@ assigns \result \from a, b;
    ensures plain: INT32_MIN <= a - b <= INT32_MAX ==> \result == a - b;
    ensures wrapped: \result == a - b || \abs(\result - (a - b)) == 0x100000000;
*/
static inline int32_t cam_wrap_sub(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/// @return a + b modulo 2^64, defined for any arguments; same instructions as a + b
/*@ assigns \result \from a, b;
    ensures plain: INT64_MIN <= a + b <= INT64_MAX ==> \result == a + b;
*/
static inline int64_t cam_wrap_add_i64(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a + (uint64_t)b);
}

/// @return a - b modulo 2^64
/*@ assigns \result \from a, b;
    ensures plain: INT64_MIN <= a - b <= INT64_MAX ==> \result == a - b;
*/
static inline int64_t cam_wrap_sub_i64(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a - (uint64_t)b);
}

/// @return a * b modulo 2^64
//@ assigns \result \from a, b;
static inline int64_t cam_wrap_times_i64(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a * (uint64_t)b);
}

/// Test a symmetric range with one comparison instead of two.
/// @param limit  0 .. 2^31 - 1
/// @return       whether -limit <= v <= limit
/*@ requires limit >= 0;
    assigns \result \from v, limit;
    ensures inside: 0 <= v <= limit ==> \result;
    ensures below: -limit <= v < 0 ==> \result;
    ensures outside: \result ==> -limit <= v <= limit;
*/
static inline bool cam_is_within(int32_t v, int32_t limit)
{
    return (uint32_t)v + (uint32_t)limit <= 2u * (uint32_t)limit;
}

/// Convert a derivative over the angle from per turn to per radian: x / 2 pi.
/// @param x  0 .. 2^41, per turn
/// @return   the same per rad, rounded down by less than 4e-7 of it plus 1
/*@ requires 0 <= x <= 0x20000000000;
    assigns \result \from x;
    ensures \result * 0x1000000 <= x * 2670176 < (\result + 1) * 0x1000000;
*/
static inline int64_t cam_per_rad(int64_t x)
{
    return (x * 2670176) >> 24; // 2^24 / 2 pi
}

/// @return whether low <= v <= high
/*@ assigns \result \from v, low, high;
    ensures \result <==> low <= v <= high;
*/
static inline bool cam_is_between(int64_t v, int64_t low, int64_t high)
{
    return v >= low && v <= high;
}

/// Angles and master positions. An angle is `theta_q32`: uint32, 2^32 = one turn, so that it wraps
/// by design; a quarter turn is 0x40000000. A master position is `pos_q32`: int64, Q32.32 turns
/// that rise while the spindle turns in the sense of cutting, and jump forwards where the index is
/// found. It cannot overflow in practice: 2^31 turns at 3000 r/min last 497 days, and every homing
/// takes them modulo 2^24.

/// 2 pi * 2^24
#define CAM_TWO_PI_Q24 INT64_C(105414357)

/// One turn of a master position.
#define CAM_TURN_Q32 ((int64_t)1 << 32)

/// @return [turn / 2^32] the angle within the turn of a master position
static inline uint32_t cam_angle_of_pos(int64_t pos_q32)
{
    return (uint32_t)((uint64_t)pos_q32);
}

/// @return [turn, Q32.32] the first whole turn at or after pos_q32
static inline int64_t cam_angle_next_turn(int64_t pos_q32)
{
    return (int64_t)(((uint64_t)pos_q32 + (uint64_t)(CAM_TURN_Q32 - 1)) &
                     ~(uint64_t)(CAM_TURN_Q32 - 1));
}

/// Fences: the interrupt's side of every hand-over to and from the slow side. The writer writes the
/// data first and then sets an atomic index or counter. The slow side uses C11 acquire and release
/// operations; the interrupt uses a relaxed operation and one of these fences. On a Cortex-M both
/// sides run on one core, so keeping the compiler's order is enough. Elsewhere (simulator, Linux)
/// they may run on different cores, and the fence is a real one.

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
