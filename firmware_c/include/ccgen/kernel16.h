/**
 * \file kernel16.h
 * \brief How a core computes angle_i = (bias_i + sum_j W_ij d_j) >> shift with 16-bit weights.
 *
 * Internal to estimator16.h. The specialised kernel is exact as long as no angle leaves its limits,
 * and says so when one does; ccgen_axis16_evaluate_any() is exact always. Sums run modulo 2^32:
 * what the exporter's proof covers is exact, and no input whatever overflows a signed type.
 */
#ifndef CCGEN_KERNEL16_H
#define CCGEN_KERNEL16_H

#include "ccgen/axis16.h"
#include "ccgen/check.h"
#include "ccgen/integer.h"

/** Whether the compiler knows the core's dual multiplication (SMLAD) and saturation (SSAT). */
#define CCGEN_HAS_SMLAD 0
#define CCGEN_HAS_SSAT 0
#if defined(__arm__) && defined(__has_builtin)
#if defined(__ARM_FEATURE_SIMD32) && __has_builtin(__builtin_arm_smlad)
#undef CCGEN_HAS_SMLAD
#define CCGEN_HAS_SMLAD 1
#include <arm_acle.h>
#endif
#if defined(__ARM_FEATURE_SAT) && __has_builtin(__builtin_arm_ssat)
#undef CCGEN_HAS_SSAT
#define CCGEN_HAS_SSAT 1
#endif
#endif

/**
 * Whether a core loads and extends 16 bits in one instruction, so that taking the halves of a pair
 * from memory is faster than from a register: all little-endian ones but Thumb-1.
 */
#if !defined(CCGEN_LOADS_HALVES)
#if defined(__GNUC__) && (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) && \
    (!defined(__thumb__) || defined(__thumb2__))
#define CCGEN_LOADS_HALVES 1
#else
#define CCGEN_LOADS_HALVES 0
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Differences count - zero of one snapshot, 0 for sensors that the axis has not. */
typedef struct {
    int32_t wide[CCGEN_AXIS_SENSORS_MAX];
} ccgen_differences16_t;

#if CCGEN_HAS_SSAT
/** \return a value clipped to what 16 bits hold; takes in a shift to the right before it. */
CCGEN_INLINE int32_t ccgen_clip16(const int32_t value) {
    return ccgen_signed32((uint32_t)__builtin_arm_ssat(value, 16));
}
#endif

#if CCGEN_HAS_SMLAD
/** \return the low halves of two values in one word. */
CCGEN_INLINE uint32_t ccgen_pack16(const int32_t low, const int32_t high) {
    uint32_t pair;
    __asm__("pkhbt %0, %1, %2, lsl #16" : "=r"(pair) : "r"(low), "r"(high));
    return pair;
}
#endif

/** \return the weight of one sensor from its segment's row. */
CCGEN_INLINE int32_t ccgen_axis16_weight(const uint32_t *const row, const uint8_t sensor) {
#if CCGEN_LOADS_HALVES
    int16_t weight;
    (void)__builtin_memcpy(&weight, (const unsigned char *)(row + 1) + 2u * sensor, sizeof weight);
    return weight;
#else
    const uint32_t pair = row[1u + sensor / 2u];
    return ((sensor % 2u) == 0u) ? ccgen_low16(pair) : ccgen_high16(pair);
#endif
}

/**
 * Adds the product of one sensor's weight and difference, nothing where there is no such sensor.
 */
CCGEN_INLINE uint32_t ccgen_axis16_add(const ccgen_axis16_t *const axis, const uint32_t sum,
                                       const uint32_t *const row,
                                       const ccgen_differences16_t *const d, const uint8_t sensor) {
    if (sensor >= axis->sensors) {
        return sum;
    }
    uint32_t next = sum + (uint32_t)(ccgen_axis16_weight(row, sensor) * d->wide[sensor]);
    CCGEN_IN_ORDER(next);
    return next;
}

/** The same for sensors 2k and 2k + 1: one instruction where the core multiplies two halves. */
CCGEN_INLINE uint32_t ccgen_axis16_add_pair(const ccgen_axis16_t *const axis, const uint32_t sum,
                                            const uint32_t *const row,
                                            const ccgen_differences16_t *const d, const uint8_t k) {
#if CCGEN_HAS_SMLAD
    if ((2u * k) < axis->sensors) {
        /* Without a second sensor its weight is 0, and the half beside it does not matter. */
        const uint32_t pair = ((2u * k + 1u) < axis->sensors)
                                  ? ccgen_pack16(d->wide[2u * k], d->wide[2u * k + 1u])
                                  : (uint32_t)d->wide[2u * k];
        return (uint32_t)__smlad((int16x2_t)ccgen_signed32(row[1u + k]),
                                 (int16x2_t)ccgen_signed32(pair), ccgen_signed32(sum));
    }
#endif
    const uint32_t half = ccgen_axis16_add(axis, sum, row, d, (uint8_t)(2u * k));
    return ccgen_axis16_add(axis, half, row, d, (uint8_t)(2u * k + 1u));
}

/** \return one segment's angle before saturation, from its row of the model. */
CCGEN_INLINE int32_t ccgen_axis16_angle(const ccgen_axis16_t *const axis, const uint32_t *const row,
                                        const ccgen_differences16_t *const d) {
    uint32_t sum = row[0];
    sum = ccgen_axis16_add_pair(axis, sum, row, d, 0);
    sum = ccgen_axis16_add_pair(axis, sum, row, d, 1);
    sum = ccgen_axis16_add_pair(axis, sum, row, d, 2);
    sum = ccgen_axis16_add_pair(axis, sum, row, d, 3);
    return ccgen_signed32(sum) >> axis->shift;
}

/** \return an angle clipped to its limit. */
CCGEN_INLINE int32_t ccgen_axis16_saturate(const int32_t angle) {
    const int32_t below = (angle < CCGEN_ANGLE16_LIMIT) ? angle : CCGEN_ANGLE16_LIMIT;
    return (below > -CCGEN_ANGLE16_LIMIT) ? below : -CCGEN_ANGLE16_LIMIT;
}

/**
 * Writes one angle.
 * \param[in,out] low  its sign bit is set when an angle that was written lies below the limit
 * \return false when the angle lies beyond its limit and was not written
 */
CCGEN_INLINE bool ccgen_axis16_put(const ccgen_axis16_t *const axis, int32_t angle,
                                   int16_t *const to, uint32_t *const low) {
    if (axis->saturates) {
#if CCGEN_HAS_SSAT
        angle = ccgen_clip16(angle);
        *low |= (uint32_t)(angle + CCGEN_ANGLE16_LIMIT);
#else
        (void)low;
        if ((angle > CCGEN_ANGLE16_LIMIT) || (angle < -CCGEN_ANGLE16_LIMIT)) {
            return false;
        }
#endif
    }
    *to = ccgen_low16((uint32_t)angle);
    return true;
}

/** Writes the angles of two segments that follow each other; the rest as ccgen_axis16_put(). */
CCGEN_INLINE bool ccgen_axis16_put_two(const ccgen_axis16_t *const axis, const uint32_t *const row,
                                       const ccgen_differences16_t *const d, int16_t *const to,
                                       uint32_t *const low) {
    const size_t words = 1u + ((size_t)axis->sensors + 1u) / 2u;
    const int32_t first = ccgen_axis16_angle(axis, row, d);
    const int32_t second = ccgen_axis16_angle(axis, row + words, d);
#if CCGEN_HAS_SMLAD && CCGEN_HAS_SSAT
    if (axis->saturates) {
        /* Saturating to 16 bits once more, one step lower, leaves out the most negative value. */
        const uint32_t pair = ccgen_pack16(ccgen_clip16(first), ccgen_clip16(second));
        const int16x2_t lowered = __qadd16((int16x2_t)ccgen_signed32(pair), (int16x2_t)-1);
        const int16x2_t both = __sadd16(lowered, (int16x2_t)0x00010001);
        (void)__builtin_memcpy(to, &both, sizeof both);
        return true;
    }
#endif
    return ccgen_axis16_put(axis, first, &to[0], low) &&
           ccgen_axis16_put(axis, second, &to[1], low);
}

/**
 * Evaluates a model for any differences and any angles: the way of the rare cases. Not specialised,
 * so one copy serves all models. Parameters as ccgen_axis16_evaluate().
 */
void ccgen_axis16_evaluate_any(const ccgen_axis16_t *axis, const int16_t *zero,
                               const int16_t *counts, int16_t *angles);

/** \return whether a difference fits 16 bits, which the dual multiplication needs. */
CCGEN_INLINE bool ccgen_axis16_fits(const ccgen_axis16_t *const axis,
                                    const ccgen_differences16_t *const d, const uint8_t sensor) {
#if CCGEN_HAS_SMLAD
    return axis->narrow || (sensor >= axis->sensors) ||
           (d->wide[sensor] == ccgen_low16((uint32_t)d->wide[sensor]));
#else
    (void)axis;
    (void)d;
    (void)sensor;
    return true;
#endif
}

/** \return whether the kernel for this core is exact for these differences. */
CCGEN_INLINE bool ccgen_axis16_suits(const ccgen_axis16_t *const axis,
                                     const ccgen_differences16_t *const d) {
    return ccgen_axis16_fits(axis, d, 0) && ccgen_axis16_fits(axis, d, 1) &&
           ccgen_axis16_fits(axis, d, 2) && ccgen_axis16_fits(axis, d, 3) &&
           ccgen_axis16_fits(axis, d, 4) && ccgen_axis16_fits(axis, d, 5) &&
           ccgen_axis16_fits(axis, d, 6) && ccgen_axis16_fits(axis, d, 7);
}

/** \return segments a turn of the loop: fewer where code is scarce and a segment takes long. */
CCGEN_INLINE uint16_t ccgen_axis16_unrolled(const ccgen_axis16_t *const axis) {
#if CCGEN_HAS_SSAT
    (void)axis;
    return 4;
#else
    return (axis->sensors <= 3u) ? 4 : 2;
#endif
}

/** The specialised kernel. \return whether all angles were written and are exact */
CCGEN_INLINE bool ccgen_axis16_evaluate_fast(const ccgen_axis16_t *const axis,
                                             const ccgen_differences16_t *const d,
                                             int16_t *const angles) {
    const size_t words = 1u + ((size_t)axis->sensors + 1u) / 2u;
    const uint16_t unrolled = ccgen_axis16_unrolled(axis);
    const uint32_t *row = axis->rows;
    int16_t *angle = angles;
    uint32_t low = 0;
    for (uint16_t i = 0; i < (axis->segments % unrolled); ++i) {
        if (!ccgen_axis16_put(axis, ccgen_axis16_angle(axis, row, d), angle, &low)) {
            return false;
        }
        ++angle;
        row += words;
    }
    for (uint16_t i = 0; i < (axis->segments / unrolled); ++i) {
        if (!ccgen_axis16_put_two(axis, row, d, angle, &low) ||
            ((unrolled == 4u) &&
             !ccgen_axis16_put_two(axis, row + 2u * words, d, angle + 2, &low))) {
            return false;
        }
        angle += unrolled;
        row += unrolled * words;
    }
    return (low >> 31) == 0u;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_KERNEL16_H */
