/**
 * \file estimator32.h
 * \brief The estimator of one bending axis with 32-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 64 bits; there is no division, float, loop over sensors or function call. Called
 * with a `static const ccgen_axis32_t` that the compiler sees, everything that depends on the
 * number of sensors, the shift and the flags is decided at compile time. Time grows with segments
 * times sensors, whatever the readings but for a few instructions where an axis may saturate.
 * Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count within [minimum, maximum] and every zero within the same
 * bounds that differences fit 32 bits, that no intermediate sum leaves 64 bits and, where
 * `saturates` is false, that every angle fits 32 bits. A zero outside its bounds gives wrong
 * angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR32_H
#define CCGEN_ESTIMATOR32_H

#include "ccgen/axis32.h"
#include "ccgen/kernel32.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Evaluates the model without checking anything: for counts that ccgen_axis32_complete() accepts,
 * so that a joint of two axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot, each within its sensor's range
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 */
CCGEN_INLINE void ccgen_axis32_evaluate(const ccgen_axis32_t *const axis, const int32_t *const zero,
                                        const int32_t *const counts, int32_t *const angles) {
    const uint64_t start = (uint64_t)axis->bias + ccgen_axis32_offset(axis);
    ccgen_factors32_t factors = {
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
    CCGEN_OPAQUE(factors.start_low);
    CCGEN_OPAQUE(factors.start_high);
    ccgen_axis32_segments(axis, &factors, angles);
}

/**
 * Estimates the angles of all segments of one axis.
 * \param[in] axis     model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or an invalid model;
 *         CCGEN_ERROR_MISSING when a count is outside its range. Nothing is written on error.
 */
CCGEN_INLINE int ccgen_axis32_estimate(const ccgen_axis32_t *const axis, const int32_t *const zero,
                                       const int32_t *const counts, int32_t *const angles) {
    if (!ccgen_axis32_valid(axis) || (zero == NULL) || (counts == NULL) || (angles == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!ccgen_axis32_complete(axis, counts)) {
        return CCGEN_ERROR_MISSING;
    }
    ccgen_axis32_evaluate(axis, zero, counts, angles);
    return CCGEN_OK;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR32_H */
