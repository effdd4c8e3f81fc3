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

/**
 * An inline function that is specialised for the constants it is called with. Not forced where the
 * compiler does not optimise: nothing would fold, and every variant of a kernel would be inlined.
 */
#if defined(__GNUC__) && defined(__OPTIMIZE__)
#define CCGEN_INLINE static inline __attribute__((always_inline))
#else
#define CCGEN_INLINE static inline
#endif

/** Initialises every field of a structure with zero, without a warning in either language. */
#if defined(__cplusplus)
#define CCGEN_ZERO \
    {              \
    }
#else
#define CCGEN_ZERO {0}
#endif

/** Most sensors on one bending axis: the status frame has eight bits for each axis. */
#define CCGEN_AXIS_SENSORS_MAX 8

/** Most segments of a joint. */
#define CCGEN_SEGMENTS_MAX 64

CCGEN_STATIC_ASSERT(CHAR_BIT == 8, bytes_have_eight_bits);
CCGEN_STATIC_ASSERT(sizeof(int16_t) == 2 && sizeof(uint16_t) == 2, int16_has_two_bytes);
CCGEN_STATIC_ASSERT(sizeof(int32_t) == 4 && sizeof(uint32_t) == 4, int32_has_four_bytes);
CCGEN_STATIC_ASSERT(sizeof(int64_t) == 8 && sizeof(uint64_t) == 8, int64_has_eight_bytes);
CCGEN_STATIC_ASSERT((-1 & 3) == 3, negative_values_are_in_two_s_complement);
CCGEN_STATIC_ASSERT(((int32_t)-5 >> 1) == -3, right_shift_of_int32_is_arithmetic);
CCGEN_STATIC_ASSERT(((int64_t)-5 >> 1) == -3, right_shift_of_int64_is_arithmetic);

#endif /* CCGEN_CHECK_H */
