/**
 * \file check32.h
 * \brief Holds a group of sensors against each other, with 32-bit counts and weights.
 *
 *     p_i = sum_k V_ik (count_k - zero_k)
 *
 * Parity values p of sound sensors are near 0, whatever the shape, as far as they decide on alarms;
 * residuals.h tells what follows from them. The exporter proves that no |p_i| + 2^quiet_bits and no
 * partial sum reaches 2^63 for differences in range. The products are those of estimator32.h; a
 * quiet snapshot takes them for `kept` values, and one comparison.
 */
#ifndef CCGEN_CHECK32_H
#define CCGEN_CHECK32_H

#include "ccgen/kernel32.h"
#include "ccgen/residuals.h"

#ifdef __cplusplus
extern "C" {
#endif

/** \return sum and the products of all sensors, whose weights stand at *row. */
CCGEN_INLINE uint64_t ccgen_parity32(const ccgen_axis32_t *const rows, const uint64_t start,
                                     const ccgen_factors32_t *const factors,
                                     const uint32_t **const row) {
    uint64_t sum = start;
    if (rows->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t sensor = 0; sensor < rows->sensors; ++sensor) {
            sum = ccgen_axis32_add(rows, sum, ccgen_load(row), factors, sensor);
        }
        return sum;
    }
    sum = ccgen_axis32_add_pair(rows, sum, factors, row, 0);
    sum = ccgen_axis32_add_pair(rows, sum, factors, row, 1);
    sum = ccgen_axis32_add_pair(rows, sum, factors, row, 2);
    return ccgen_axis32_add_pair(rows, sum, factors, row, 3);
}

/** Finds parity values from the first on, in 16 bits. \return bits that they lost more. */
static inline uint8_t ccgen_shortened32(const ccgen_check_t *const check,
                                        const int64_t *const parity, const uint8_t values,
                                        int16_t *const shortened) {
    uint64_t sizes = 0;
    for (uint8_t i = 0; i < values; ++i) {
        sizes |= (uint64_t)(parity[i] < 0 ? -(parity[i] + 1) : parity[i]);
    }
    uint8_t more = 0;
    for (sizes >>= check->shift; sizes > 0x7FFFu; sizes >>= 1) {
        ++more;
    }
    for (uint8_t i = 0; i < values; ++i) {
        shortened[i] = (int16_t)(parity[i] >> (check->shift + more));
    }
    return more;
}

/** Finds parity values of a group whose number of sensors need not be known to the compiler. */
static inline void ccgen_values32(const ccgen_axis32_t *const rows,
                                  const ccgen_factors32_t *const factors,
                                  const uint32_t **const row, int64_t *const parity,
                                  const uint8_t values) {
    for (uint8_t i = 0; i < values; ++i) {
        uint64_t sum = 0;
        for (uint8_t j = 0; j < rows->sensors; ++j) {
            sum = ccgen_axis32_add(rows, sum, ccgen_load(row), factors, j);
        }
        parity[i] = ccgen_signed64(sum);
    }
}

/** \return the verdict over a snapshot that is not quiet, with code that serves every group. */
CCGEN_INLINE uint8_t ccgen_examine32(const ccgen_axis32_t *const rows,
                                     const ccgen_check_t *const check, const int32_t *const zero,
                                     const int32_t *const counts) {
    int64_t parity[CCGEN_SENSORS_MAX];
    int16_t shortened[CCGEN_SENSORS_MAX];
    uint32_t size[CCGEN_SENSORS_MAX];
    const uint32_t *row = (const uint32_t *)rows->weights; /* the unsigned type may alias */
    const uint8_t kept = check->kept;
    ccgen_factors32_t factors = CCGEN_ZERO;
    for (uint8_t j = 0; j < check->sensors; ++j) {
        factors.difference[j] = ccgen_axis32_difference(rows, zero, counts, j);
    }
    ccgen_values32(rows, &factors, &row, parity, kept);
    uint8_t more = ccgen_shortened32(check, parity, kept, shortened);
    ccgen_residuals(check, shortened, kept, size);
    if (!ccgen_alarms(check, size, more)) {
        return CCGEN_VERDICT_QUIET;
    }
    ccgen_values32(rows, &factors, &row, parity + kept, (uint8_t)(check->sensors - kept));
    more = ccgen_shortened32(check, parity, check->sensors, shortened);
    ccgen_residuals(check, shortened, check->sensors, size);
    return ccgen_named(check, size, more);
}

/**
 * Tells whether a snapshot is quiet, and nothing more need be known of it.
 * \param[in] rows    V, as the rows of an axis with as many segments as sensors, whose bias and
 *                    shift are 0 and which does not saturate
 * \param[in] check
 * \param[in] zero    [sensors] counts at the straight pose
 * \param[in] counts  [sensors] every one a reading
 */
CCGEN_INLINE bool ccgen_check32(const ccgen_axis32_t *const rows, const ccgen_check_t *const check,
                                const int32_t *const zero, const int32_t *const counts) {
    const uint32_t *row = (const uint32_t *)rows->weights; /* the unsigned type may alias */
    const uint64_t start = (uint64_t)1 << check->quiet_bits;
    ccgen_factors32_t factors = CCGEN_ZERO;
    for (uint8_t j = 0; j < rows->sensors; ++j) {
        factors.difference[j] = ccgen_axis32_difference(rows, zero, counts, j);
    }
    uint64_t all = 0;
    for (uint8_t i = 0; i < check->kept; ++i) {
        all |= ccgen_parity32(rows, start, &factors, &row);
    }
    return ((all >> check->quiet_bits) >> 1) == 0u;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CHECK32_H */
