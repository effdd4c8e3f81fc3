/**
 * \file kernel16.h
 * \brief The sums and angles of estimator16.h, as each kind of core does them best.
 *
 * All arithmetic is modulo 2^32: sums that the exporter's proof covers are exact, and no input
 * overflows a signed type. Same bits on every core.
 */
#ifndef CCGEN_KERNEL16_H
#define CCGEN_KERNEL16_H

#include "ccgen/factors16.h"
#include "ccgen/integer.h"
#include "ccgen/kernel16_thumb1.h"
#include "ccgen/load.h"
#include "ccgen/product.h"

#if defined(__ARM_FEATURE_SIMD32) || CCGEN_HAS_SSAT
#include <arm_acle.h>
#endif

#ifdef __cplusplus
extern "C" {
#endif

#if CCGEN_HALVES
/**
 * \return sum and the products of the lower and, where there are two sensors, of the upper halves
 * of two words.
 */
CCGEN_INLINE uint32_t ccgen_add_halves(const uint32_t sum, const uint32_t a, const uint32_t b,
                                       const bool two) {
#if defined(__ARM_FEATURE_SIMD32)
    (void)two; /* the other weight is 0 */
    return (uint32_t)__smlad(ccgen_signed32(a), ccgen_signed32(b), ccgen_signed32(sum));
#else
    const uint32_t lower = ccgen_add_product16(sum, ccgen_low16(a), ccgen_low16(b));
    return two ? ccgen_add_product16(lower, ccgen_high16(a), ccgen_high16(b)) : lower;
#endif
}
#endif

/** \return sum and the products of sensors 2k and 2k + 1, where the axis has them. */
CCGEN_INLINE uint32_t ccgen_add_pair16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                       const uint32_t weights,
                                       const ccgen_factors16_t *const factors, const uint8_t k) {
    if (2u * k >= axis->sensors) {
        return sum;
    }
#if CCGEN_HALVES
    const bool two = 2u * k + 1u < axis->sensors;
    const uint32_t most = ccgen_add_halves(sum, weights, factors->pair[2u * k], two);
    return factors->narrow ? most
                           : ccgen_add_halves(most, weights, factors->pair[2u * k + 1u], two);
#else
    uint32_t result = sum + weights * factors->pair[2u * k];
    CCGEN_OPAQUE(result);
    if (2u * k + 1u < axis->sensors) {
        /* MISRA 10.1 */
        result += (uint32_t)(ccgen_signed32(weights) >> 16) * factors->pair[2u * k + 1u];
        CCGEN_OPAQUE(result);
    }
    return result;
#endif
}

#if CCGEN_HAS_SSAT
/* The compiler's own macro converts without a cast. */
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wsign-conversion"
#endif
/** \return value clipped to -32768 to 32767, modulo 2^32. */
CCGEN_INLINE uint32_t ccgen_clip16(const int32_t value) {
    return (uint32_t)__ssat(value, 16);
}
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#endif

/** \return sum / 2^shift of an axis, rounded down; a sum modulo 2^32 that counts as signed. */
CCGEN_INLINE int32_t ccgen_steps16(const ccgen_axis16_t *const axis, const uint32_t sum) {
    int32_t steps = ccgen_signed32(sum);
#if UINT_MAX < 0xFFFFFFFFu /* MISRA 20.9 */
    uint8_t bits = axis->shift;
#if defined(__GNUC__)
    if (__builtin_constant_p(axis->shift) != 0) {
        return ccgen_right(steps, axis->shift);
    }
#endif
    for (; bits >= 8u; bits = CCGEN_CAST(uint8_t, bits - 8u)) {
        /* MISRA 10.1 */
        steps >>= 8; /* bytes move at once, bits one at a time */
    }
    return steps >> bits; /* MISRA 10.1 */
#else
    return steps >> axis->shift; /* MISRA 10.1 */
#endif
}

/** Stores the angle of a whole sum. */
CCGEN_INLINE void ccgen_store16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                int16_t *const angle) {
    uint32_t steps = (uint32_t)ccgen_steps16(axis, sum);
    if (axis->saturates) {
#if defined(__ARM_FEATURE_SIMD32)
        const uint32_t clipped = ccgen_clip16(ccgen_signed32(sum) >> axis->shift); /* MISRA 10.1 */
        steps = (uint32_t)__qadd16(ccgen_signed32(clipped), 1);
#elif CCGEN_HAS_SSAT
        const uint32_t clipped = ccgen_clip16(ccgen_signed32(sum) >> axis->shift); /* MISRA 10.1 */
        /* MISRA 10.4 */
        steps = clipped + ((clipped + CCGEN_ANGLE16_LIMIT) >> 31); /* -32768 becomes -32767 */
#else
#if UINT_MAX < 0xFFFFFFFFu /* MISRA 20.9 */
        steps &= CCGEN_CAST(uint32_t, 0xFFFFFFFFu) >> axis->shift; /* as of an unsigned sum */
#else
        steps = sum >> axis->shift;
#endif
        if (steps > 2u * CCGEN_ANGLE16_LIMIT) { /* MISRA 10.4 */
            const uint32_t without = sum - ((uint32_t)CCGEN_ANGLE16_LIMIT << axis->shift);
            steps = (without >= 0x80000000u) ? 0u : 2u * CCGEN_ANGLE16_LIMIT; /* MISRA 10.4 */
        }
        steps -= CCGEN_ANGLE16_LIMIT; /* MISRA 10.4 */
#endif
    }
    *(uint16_t *)angle = (uint16_t)(steps & 0xFFFFu); /* the unsigned type may alias */
}

/** \return sum and the products of sensors 4h to 4h + 3, whose weights stand at *row. */
CCGEN_INLINE uint32_t ccgen_add_pairs16(const ccgen_axis16_t *const axis, const uint32_t sum,
                                        const ccgen_factors16_t *const factors,
                                        const uint32_t **const row, const uint8_t h) {
    const uint8_t pair = (uint8_t)(2u * h);
    uint32_t first = 0;
    uint32_t second = 0;
    if (ccgen_words16(axis) > (pair + 1u)) {
        ccgen_load_two(row, &first, &second);
    } else if (ccgen_words16(axis) > pair) {
        first = ccgen_load(row);
    } else {
        return sum;
    }
    const uint32_t half = ccgen_add_pair16(axis, sum, first, factors, pair);
    return ccgen_add_pair16(axis, half, second, factors, (uint8_t)(pair + 1u));
}

/** Estimates segment k of a turn from its row at *row, which moves on to the next. */
CCGEN_INLINE void ccgen_segment16(const ccgen_axis16_t *const axis,
                                  const ccgen_factors16_t *const factors,
                                  const uint32_t **const row, const int32_t *const biases,
                                  int16_t *const angles, const uint8_t k) {
    uint32_t sum = factors->start;
    if (axis->biases != NULL) {
        sum += (uint32_t)biases[k];
    }
    if (axis->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t pair = 0; pair < ccgen_words16(axis); ++pair) {
            sum = ccgen_add_pair16(axis, sum, ccgen_load(row), factors, pair);
        }
    } else {
        sum = ccgen_add_pairs16(axis, sum, factors, row, 0);
        sum = ccgen_add_pairs16(axis, sum, factors, row, 1);
    }
    ccgen_store16(axis, sum, angles + k);
}

/** Estimates all segments: four a turn, three, two or one, as their number divides. */
CCGEN_INLINE void ccgen_segments16(const ccgen_axis16_t *const axis,
                                   const ccgen_factors16_t *const factors,
                                   int16_t *const angles) {
    /* A product takes a compiler about twice the code that it takes by hand. */
    const uint16_t turn = ccgen_turn(axis->segments, (uint8_t)(2u * axis->sensors));
    const uint32_t *row = axis->rows;
    const int32_t *biases = axis->biases;
    int16_t *angle = angles;
    const int16_t *end = angles + axis->segments;
    CCGEN_OPAQUE(end); /* or else short loops are unrolled whole */
    do {
        ccgen_segment16(axis, factors, &row, biases, angle, 0);
        if (turn > 1u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 1);
        }
        if (turn > 2u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 2);
        }
        if (turn > 3u) {
            ccgen_segment16(axis, factors, &row, biases, angle, 3);
        }
        if (axis->biases != NULL) {
            biases += turn;
        }
        angle += turn;
    } while (angle != end);
}

/** Estimates all segments; `narrow` tells whether every difference fits 16 bits. */
CCGEN_INLINE void ccgen_evaluate16(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                   const int16_t *const counts, const bool narrow,
                                   int16_t *const angles) {
#if CCGEN_HAS_THUMB1_LOOP
    if (__builtin_constant_p(axis->sensors) && __builtin_constant_p(axis->segments) &&
        __builtin_constant_p(axis->saturates) && (axis->biases == NULL) &&
        (axis->sensors <= CCGEN_UNROLLED_MAX)) {
        if (__builtin_constant_p(axis->shift)) {
            ccgen_thumb1_evaluate16(axis, zero, counts, true, angles);
        } else {
            ccgen_thumb1_evaluate16(axis, zero, counts, false, angles);
        }
        return;
    }
#endif
    ccgen_factors16_t factors = CCGEN_ZERO;
    factors.narrow = narrow;
    factors.start = ccgen_start16(axis);
    ccgen_prepare16(axis, zero, counts, 0, &factors);
    ccgen_prepare16(axis, zero, counts, 1, &factors);
    ccgen_prepare16(axis, zero, counts, 2, &factors);
    ccgen_prepare16(axis, zero, counts, 3, &factors);
    for (uint8_t pair = CCGEN_PAIRS_UNROLLED; pair < ccgen_words16(axis); ++pair) {
        ccgen_prepare16(axis, zero, counts, pair, &factors);
    }
    ccgen_segments16(axis, &factors, angles);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_KERNEL16_H */
