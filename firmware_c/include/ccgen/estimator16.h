/**
 * \file estimator16.h
 * \brief The estimator of one output axis with 16-bit counts, weights and angles.
 *
 *     angle_i = saturate((bias_i + sum_j W_ij (count_j - zero_j)) >> shift)
 *
 * Accumulates in 32 bits; there is no division, float, 64-bit arithmetic or function call, and
 * no loop over up to 8 sensors. Called with a `static const ccgen_axis16_t` that the compiler sees, everything
 * that depends on the number of sensors, the shift and the flags is decided at compile time.
 * Time grows with segments times sensors and does not depend on the readings but for a few
 * instructions: where an axis may saturate, and where a core multiplies two halves at once and a
 * difference does not fit 16 bits. Re-entrant; the state belongs to the caller.
 *
 * The exporter proves for every count and zero that sensors16.h accepts that no intermediate sum
 * leaves 32 bits and, where `saturates` is false, that every angle fits 16 bits. A zero outside its
 * bounds gives wrong angles, never undefined behaviour.
 */
#ifndef CCGEN_ESTIMATOR16_H
#define CCGEN_ESTIMATOR16_H

#include "ccgen/axis16.h"
#include "ccgen/kernel16.h"

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Evaluates the model without checking anything: for counts that ccgen_sensors16_complete()
 * accepts, so that a joint of several axes is checked as a whole before anything is written.
 * \param[in] axis     valid model
 * \param[in] zero     [sensors] counts at the straight pose, each accepted for its sensor
 * \param[in] counts   [sensors] counts of one snapshot, each a reading
 * \param[out] angles  [segments] angles in steps of 2^-fraction_bits rad; may not overlap the
 * inputs
 */
CCGEN_INLINE void ccgen_axis16_evaluate(const ccgen_axis16_t *const axis, const int16_t *const zero,
                                        const int16_t *const counts, int16_t *const angles) {
    const bool narrow = ccgen_fits_halves16(axis, zero, counts);
#if CCGEN_SMALL
    ccgen_evaluate16(axis, zero, counts, narrow, angles);
#else
    if (narrow) {
        ccgen_evaluate16(axis, zero, counts, true, angles);
    } else {
        ccgen_evaluate16(axis, zero, counts, false, angles);
    }
#endif
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_ESTIMATOR16_H */
