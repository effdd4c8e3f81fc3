/**
 * \file axis16.h
 * \brief The model of one output axis with 16-bit counts, weights and angles: a table in flash.
 *
 * Two weights share a word, and how they do depends on what the core multiplies best:
 * - halves: each weight in its half, for cores that multiply both halves at once (SMLAD) and for
 *   those whose int has 16 bits;
 * - combined: high * 2^16 + low + 2^15. With word = that sum and high = word >> 16,
 *
 *       low a + high b = word a + high (b - 2^16 a) - 2^15 a   (mod 2^32)
 *
 *   holds for any differences a and b. The factor b - 2^16 a and the last term are the same for
 *   all segments, so that a pair costs one shift and two multiplications, and no extraction.
 */
#ifndef CCGEN_AXIS16_H
#define CCGEN_AXIS16_H

#include "ccgen/check.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Whether weights are stored as halves; may be set to 0 or 1 to try the other layout. */
#if !defined(CCGEN_HALVES)
#if defined(__ARM_FEATURE_SIMD32) || (UINT_MAX < 0xFFFFFFFFu) /* MISRA 20.9 */
#define CCGEN_HALVES 1
#else
#define CCGEN_HALVES 0
#endif
#endif

/** Two signed 16-bit weights in one word of `rows`: constant expression of constants. */
#if CCGEN_HALVES
#define CCGEN_PAIR(low, high) ((uint32_t)(uint16_t)(low) | ((uint32_t)(uint16_t)(high) << 16))
#else
#define CCGEN_PAIR(low, high) (((uint32_t)(high) << 16) + (uint32_t)((int32_t)(low) + 0x8000))
#endif

/** The model of one axis: lives in flash. */
typedef struct {
    uint16_t segments;      /**< 1 to CCGEN_SEGMENTS_MAX; of elongation: sections */
    uint8_t sensors;        /**< 1 to CCGEN_SENSORS_MAX */
    uint8_t shift;          /**< 0 to 31; 0 to 16 where `saturates` */
    uint8_t fraction_bits;  /**< an angle is in steps of 2^-fraction_bits rad */
    bool saturates;         /**< some readings in range exceed the angle's limit */
    bool narrow;            /**< every difference count - zero fits 16 bits */
    int32_t bias;           /**< intercept and rounding half at the sum's scale */
    const int32_t *biases;  /**< [segments] what a segment adds to `bias`; NULL where none does */
    /**
     * [segments][(sensors + 1) / 2] words: CCGEN_PAIR(W_i0, W_i1), ...; an odd number of sensors
     * is padded with a weight of 0.
     */
    const uint32_t *rows;
} ccgen_axis16_t;

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_AXIS16_H */
