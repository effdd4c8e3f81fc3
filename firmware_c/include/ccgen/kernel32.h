/**
 * \file kernel32.h
 * \brief How angle_i = (bias_i + sum_j W_ij d_j) >> shift is computed with 32-bit weights.
 *
 * Internal to estimator32.h. The specialised kernel is exact as long as no angle leaves its limits,
 * and says so when one does; ccgen_axis32_evaluate_any() is exact always. Sums run modulo 2^64:
 * what the exporter's proof covers is exact, and no input whatever overflows a signed type.
 */
#ifndef CCGEN_KERNEL32_H
#define CCGEN_KERNEL32_H

#include "ccgen/axis32.h"
#include "ccgen/check.h"
#include "ccgen/integer.h"

/** Whether the core multiplies and adds 64 bits in one instruction (SMLAL). */
#if defined(__GNUC__) && defined(__thumb2__)
#define CCGEN_HAS_SMLAL 1
#else
#define CCGEN_HAS_SMLAL 0
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Differences count - zero of one snapshot, 0 for sensors that the axis has not. */
typedef struct {
    int32_t value[CCGEN_AXIS_SENSORS_MAX];
} ccgen_differences32_t;

/** A sum in two halves, as cores of 32 bits have it. */
typedef struct {
    uint32_t low;
    uint32_t high;
} ccgen_sum32_t;

/** Adds the product of one weight with its sensor's difference, nothing for a sensor too many. */
CCGEN_INLINE void ccgen_axis32_add(const ccgen_axis32_t *const axis, ccgen_sum32_t *const sum,
                                   const int32_t *const weights,
                                   const ccgen_differences32_t *const d, const uint8_t sensor) {
    if (sensor < axis->sensors) {
#if CCGEN_HAS_SMLAL
        /* Left to itself a compiler gathers the products first, and adds the bias in two steps. */
        __asm__("smlal %0, %1, %2, %3"
                : "+r"(sum->low), "+r"(sum->high)
                : "r"(weights[sensor]), "r"(d->value[sensor]));
#else
        const uint64_t wide = (((uint64_t)sum->high << 32) | sum->low) +
                              (uint64_t)((int64_t)weights[sensor] * d->value[sensor]);
        sum->low = (uint32_t)(wide & 0xFFFFFFFFu);
        sum->high = (uint32_t)(wide >> 32);
#endif
    }
}

#if CCGEN_HAS_SMLAL
/** The same for all sensors of an axis of three, for which there are registers enough. */
CCGEN_INLINE void ccgen_axis32_add_three(ccgen_sum32_t *const sum, const int32_t *const weights,
                                         const ccgen_differences32_t *const d) {
    __asm__("smlal %0, %1, %2, %3\n\tsmlal %0, %1, %4, %5\n\tsmlal %0, %1, %6, %7"
            : "+&r"(sum->low), "+&r"(sum->high)
            : "r"(weights[0]), "r"(d->value[0]), "r"(weights[1]), "r"(d->value[1]), "r"(weights[2]),
              "r"(d->value[2]));
}
#endif

/** \return one segment's angle times 2^shift from its bias and its row of weights. */
CCGEN_INLINE ccgen_sum32_t ccgen_axis32_sum(const ccgen_axis32_t *const axis, const int64_t bias,
                                            const int32_t *const weights,
                                            const ccgen_differences32_t *const d) {
    ccgen_sum32_t sum = {(uint32_t)((uint64_t)bias & 0xFFFFFFFFu),
                         (uint32_t)((uint64_t)bias >> 32)};
#if CCGEN_HAS_SMLAL
    if (axis->sensors == 3u) {
        ccgen_axis32_add_three(&sum, weights, d);
        return sum;
    }
#endif
    ccgen_axis32_add(axis, &sum, weights, d, 0);
    ccgen_axis32_add(axis, &sum, weights, d, 1);
    ccgen_axis32_add(axis, &sum, weights, d, 2);
    ccgen_axis32_add(axis, &sum, weights, d, 3);
    ccgen_axis32_add(axis, &sum, weights, d, 4);
    ccgen_axis32_add(axis, &sum, weights, d, 5);
    ccgen_axis32_add(axis, &sum, weights, d, 6);
    ccgen_axis32_add(axis, &sum, weights, d, 7);
    return sum;
}

/** \return the low 32 bits of a sum shifted to the right. */
CCGEN_INLINE int32_t ccgen_axis32_shifted(const ccgen_axis32_t *const axis,
                                          const ccgen_sum32_t sum) {
    if (axis->shift == 0u) {
        return ccgen_signed32(sum.low);
    }
    if (axis->shift < 32u) {
        return ccgen_signed32((sum.low >> axis->shift) | (sum.high << (32u - axis->shift)));
    }
    return ccgen_signed32(sum.high) >> (axis->shift - 32u);
}

/**
 * Evaluates a model for any angles: the way of the rare cases. Not specialised, so one copy serves
 * all models. Parameters as ccgen_axis32_evaluate().
 */
void ccgen_axis32_evaluate_any(const ccgen_axis32_t *axis, const int32_t *zero,
                               const int32_t *counts, int32_t *angles);

/** \return whether the kernel notices every angle beyond its limit, or none is possible. */
CCGEN_INLINE bool ccgen_axis32_suits(const ccgen_axis32_t *const axis) {
    return !axis->saturates || ((axis->shift >= 1u) && (axis->shift <= 32u));
}

/**
 * Writes the angle of one segment.
 * \param[in,out] excess  gathers the bits by which the sums' upper halves differ from their sign:
 *                        all angles fit 32 bits when none reaches bit shift - 1
 * \return false when the angle is the value that means "no reading"
 */
CCGEN_INLINE bool ccgen_axis32_put(const ccgen_axis32_t *const axis, const ccgen_sum32_t sum,
                                   int32_t *const to, uint32_t *const excess) {
    const int32_t angle = ccgen_axis32_shifted(axis, sum);
    *to = angle;
    if (axis->saturates) {
        const int32_t high = ccgen_signed32(sum.high);
        *excess |= (uint32_t)(high ^ (high >> 31));
        return angle != INT32_MIN;
    }
    return true;
}

/** The specialised kernel. \return whether all angles are exact */
CCGEN_INLINE bool ccgen_axis32_evaluate_fast(const ccgen_axis32_t *const axis,
                                             const ccgen_differences32_t *const d,
                                             int32_t *const angles) {
    const int64_t *bias = axis->bias;
    const int32_t *weights = axis->weights;
    int32_t *angle = angles;
    uint32_t excess = 0;
    if ((axis->segments % 2u) != 0u) {
        if (!ccgen_axis32_put(axis, ccgen_axis32_sum(axis, bias[0], weights, d), angle, &excess)) {
            return false;
        }
        ++angle;
        ++bias;
        weights += axis->sensors;
    }
    for (uint16_t i = 0; i < (axis->segments / 2u); ++i) {
        const int32_t *const next = weights + axis->sensors;
        if (!ccgen_axis32_put(axis, ccgen_axis32_sum(axis, bias[0], weights, d), &angle[0],
                              &excess) ||
            !ccgen_axis32_put(axis, ccgen_axis32_sum(axis, bias[1], next, d), &angle[1], &excess)) {
            return false;
        }
        angle += 2;
        bias += 2;
        weights = next + axis->sensors;
    }
    return !axis->saturates || ((excess >> (axis->shift - 1u)) == 0u);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_KERNEL32_H */
