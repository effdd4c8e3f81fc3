/**
 * \file estimator16.h
 * \brief The estimator of one bending axis with 16-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 32 bits; there is no division, float, 64-bit arithmetic or loop over sensors.
 * Called with a `static const ccgen_axis16_t` that the compiler sees, everything that depends on
 * the number of sensors, the shift and the flags is decided at compile time. Time grows with
 * segments times sensors, and is longest, about three times the usual, when an angle reaches its
 * limit or a difference leaves 16 bits on a core that multiplies two halves at once: then
 * ccgen_axis16_evaluate_any() repeats the axis. Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count within [minimum, maximum] and every zero within the same
 * bounds that no intermediate sum leaves 32 bits and, where `saturates` is false, that every angle
 * fits 16 bits. A zero outside its bounds gives wrong angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR16_H
#define CCGEN_ESTIMATOR16_H

#include "ccgen/axis16.h"
#include "ccgen/check.h"
#include "ccgen/error.h"
#include "ccgen/kernel16.h"

#ifdef __cplusplus
extern "C" {
#endif

/** \return count - zero of one sensor, 0 where the axis has no such sensor. */
CCGEN_INLINE int32_t ccgen_axis16_difference(const ccgen_axis16_t *const axis,
                                             const int16_t *const zero, const int16_t *const counts,
                                             const uint8_t sensor) {
    return (sensor < axis->sensors) ? ((int32_t)counts[sensor] - (int32_t)zero[sensor]) : 0;
}

/**
 * Evaluates the model without checking anything: for counts that ccgen_axis16_complete() accepts,
 * so that a joint of two axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each within its sensor's range
 * \param[in] counts   [sensors] counts of one snapshot, each within its sensor's range
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; does not overlap inputs
 */
CCGEN_INLINE void ccgen_axis16_evaluate(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                        const int16_t *const counts, int16_t *const angles) {
    const ccgen_differences16_t differences = {{
        ccgen_axis16_difference(axis, zero, counts, 0),
        ccgen_axis16_difference(axis, zero, counts, 1),
        ccgen_axis16_difference(axis, zero, counts, 2),
        ccgen_axis16_difference(axis, zero, counts, 3),
        ccgen_axis16_difference(axis, zero, counts, 4),
        ccgen_axis16_difference(axis, zero, counts, 5),
        ccgen_axis16_difference(axis, zero, counts, 6),
        ccgen_axis16_difference(axis, zero, counts, 7),
    }};
    if (!ccgen_axis16_suits(axis, &differences) ||
        !ccgen_axis16_evaluate_fast(axis, &differences, angles)) {
        ccgen_axis16_evaluate_any(axis, zero, counts, angles);
    }
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
CCGEN_INLINE int ccgen_axis16_estimate(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                       const int16_t *const counts, int16_t *const angles) {
    if (!ccgen_axis16_valid(axis) || (zero == NULL) || (counts == NULL) || (angles == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (!ccgen_axis16_complete(axis, counts)) {
        return CCGEN_ERROR_MISSING;
    }
    ccgen_axis16_evaluate(axis, zero, counts, angles);
    return CCGEN_OK;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR16_H */
