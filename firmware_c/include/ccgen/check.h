/**
 * \file check.h
 * \brief What the runtime assumes about the C implementation, checked at compile time.
 *
 * Needs stdint.h, stdbool.h and stddef.h of a C99 or C++11 compiler; no library.
 */
#ifndef CCGEN_CHECK_H
#define CCGEN_CHECK_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** Refuses to compile where `cond` is false; `name` is an identifier unique in its file. */
#if defined(__cplusplus)
#define CCGEN_STATIC_ASSERT(cond, name) static_assert(cond, #name)
#else
#define CCGEN_STATIC_ASSERT(cond, name) typedef char ccgen_assert_##name[(cond) ? 1 : -1]
#endif

/** Converts a number by the cast of either language. */
#if defined(__cplusplus)
#define CCGEN_CAST(type, value) static_cast<type>(value) /* MISRA 20.7 */
#else
#define CCGEN_CAST(type, value) ((type)(value))
#endif

/**
 * An inline function that is specialised for the constants it is called with. Not forced where the
 * compiler does not optimise: nothing would fold, and every variant of a kernel would be inlined.
 */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define CCGEN_INLINE static inline __attribute__((always_inline))
#else
#define CCGEN_INLINE static inline
#endif

/** Whether the core has the small instruction set of Cortex-M0, M0+, M1 and M23. */
#if defined(__thumb__) && !defined(__thumb2__)
#define CCGEN_THUMB1 1
#else
#define CCGEN_THUMB1 0
#endif

/** Whether flash is short where such cores are used: Thumb-1, and ints of 16 bits (AVR). */
#if CCGEN_THUMB1 || (UINT_MAX < 0xFFFFFFFFu) /* MISRA 20.9 */
#define CCGEN_SMALL 1
#else
#define CCGEN_SMALL 0
#endif

/** A function that is never inlined: it exists once, and its frame is not its caller's too. */
#if defined(__GNUC__)
#define CCGEN_ONCE static __attribute__((noinline))
#else
#define CCGEN_ONCE static
#endif

/**
 * A function for models that differ: where flash is short one for all of them, which reads what it
 * is called with; elsewhere specialised for each.
 */
#if !CCGEN_SMALL
#define CCGEN_SHARED CCGEN_INLINE
#elif defined(__GNUC__) && !defined(__clang__)
#define CCGEN_SHARED static __attribute__((noinline, noclone))
#else
#define CCGEN_SHARED CCGEN_ONCE
#endif

/** Initialises every field of a structure with zero, without a warning in either language. */
#if defined(__cplusplus)
#define CCGEN_ZERO \
    {              \
    }
#else
#define CCGEN_ZERO {0}
#endif

/** Most sensors of a joint: the status frame has a bit for each. */
#define CCGEN_SENSORS_MAX 16u

/** Most sensors of an axis whose products stand one after the other; more are looped over. */
#define CCGEN_UNROLLED_MAX 8u

/** Most output axes of a joint: bending u and v, elongation h. */
#define CCGEN_AXES_MAX 3u

/** Most segments of a joint. */
#define CCGEN_SEGMENTS_MAX 64u

CCGEN_STATIC_ASSERT(CHAR_BIT == 8, bytes_have_eight_bits);
CCGEN_STATIC_ASSERT(sizeof(int16_t) == 2 && sizeof(uint16_t) == 2, int16_has_two_bytes);
CCGEN_STATIC_ASSERT(sizeof(int32_t) == 4 && sizeof(uint32_t) == 4, int32_has_four_bytes);
CCGEN_STATIC_ASSERT(sizeof(int64_t) == 8 && sizeof(uint64_t) == 8, int64_has_eight_bytes);
CCGEN_STATIC_ASSERT((-1 & 3) == 3, negative_values_are_in_two_s_complement);
CCGEN_STATIC_ASSERT((-INT32_C(5) >> 1) == -3, right_shift_of_int32_is_arithmetic);
CCGEN_STATIC_ASSERT((-INT64_C(5) >> 1) == -3, right_shift_of_int64_is_arithmetic);

#endif /* CCGEN_CHECK_H */
