/**
 * \file estimator32.h
 * \brief The estimator of one output axis with 32-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 64 bits; there is no division, float or function call, and no loop over up to 8
 * sensors. Called with a `static const ccgen_axis32_t` that the compiler sees, everything that depends on the
 * number of sensors, the shift and the flags is decided at compile time. Time grows with segments
 * times sensors, whatever the readings but for a few instructions where an axis may saturate.
 * Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count and zero that sensors32.h accepts that differences fit 32
 * bits, that no intermediate sum leaves 64 bits and, where `saturates` is false, that every angle
 * fits 32 bits. A zero outside its bounds gives wrong angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR32_H
#define CCGEN_ESTIMATOR32_H

#include "ccgen/axis32.h"
#include "ccgen/kernel32.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Evaluates the model without checking anything: for counts that ccgen_sensors32_complete()
 * accepts, so that a joint of several axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each accepted for its sensor
 * \param[in] counts   [sensors] counts of one snapshot, each a reading
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 */
CCGEN_INLINE void ccgen_axis32_evaluate(const ccgen_axis32_t *const axis, const int32_t *const zero,
                                        const int32_t *const counts, int32_t *const angles) {
    const uint64_t start = (uint64_t)axis->bias + ccgen_axis32_offset(axis);
    ccgen_factors32_t factors = { /* MISRA 9.3 */
        (uint32_t)(start & 0xFFFFFFFFu),
        (uint32_t)(start >> 32),
        {
            ccgen_axis32_difference(axis, zero, counts, 0),
            ccgen_axis32_difference(axis, zero, counts, 1),
            ccgen_axis32_difference(axis, zero, counts, 2),
            ccgen_axis32_difference(axis, zero, counts, 3),
            ccgen_axis32_difference(axis, zero, counts, 4),
            ccgen_axis32_difference(axis, zero, counts, 5),
            ccgen_axis32_difference(axis, zero, counts, 6),
            ccgen_axis32_difference(axis, zero, counts, 7),
        },
    };
    for (uint8_t j = CCGEN_UNROLLED_MAX; j < axis->sensors; ++j) {
        factors.difference[j] = ccgen_axis32_difference(axis, zero, counts, j);
    }
    CCGEN_OPAQUE(factors.start_low);
    CCGEN_OPAQUE(factors.start_high);
    ccgen_axis32_segments(axis, &factors, angles);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR32_H */
