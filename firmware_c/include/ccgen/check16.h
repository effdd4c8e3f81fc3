/**
 * \file check16.h
 * \brief Holds a group of sensors against each other, with 16-bit counts and weights.
 *
 *     p_i = sum_k V_ik (count_k - zero_k)
 *
 * Parity values p of sound sensors are near 0, whatever the shape, as far as they decide on alarms;
 * residuals.h tells what follows from them. The exporter proves that no |p_i| + 2^quiet_bits and no
 * partial sum reaches 2^31 for differences in range. The products are those of estimator16.h; a
 * quiet snapshot takes them for `kept` values, and one comparison.
 */
#ifndef CCGEN_CHECK16_H
#define CCGEN_CHECK16_H

#include "ccgen/kernel16.h"
#include "ccgen/residuals.h"

#ifdef __cplusplus
extern "C" {
#endif

/** \return sum and the products of all sensors, whose weights stand at *row. */
CCGEN_INLINE uint32_t ccgen_parity16(const ccgen_axis16_t *const rows,
                                     const ccgen_factors16_t *const factors,
                                     const uint32_t **const row) {
    uint32_t sum = factors->start;
    if (rows->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t pair = 0; pair < ccgen_words16(rows); ++pair) {
            sum = ccgen_add_pair16(rows, sum, ccgen_load(row), factors, pair);
        }
        return sum;
    }
    sum = ccgen_add_pairs16(rows, sum, factors, row, 0);
    return ccgen_add_pairs16(rows, sum, factors, row, 1);
}

/** Whether no value that decides on alarms leaves the quiet box; each is 2^quiet_bits high. */
CCGEN_INLINE bool ccgen_quiet16(const ccgen_axis16_t *const rows, const ccgen_check_t *const check,
                                const int16_t *const zero, const int16_t *const counts,
                                const bool narrow) {
    const uint32_t *row = rows->rows;
    ccgen_factors16_t factors = CCGEN_ZERO;
    factors.narrow = narrow;
    factors.start = (uint32_t)1 << check->quiet_bits;
    ccgen_prepare16(rows, zero, counts, 0, &factors);
    ccgen_prepare16(rows, zero, counts, 1, &factors);
    ccgen_prepare16(rows, zero, counts, 2, &factors);
    ccgen_prepare16(rows, zero, counts, 3, &factors);
    for (uint8_t pair = CCGEN_PAIRS_UNROLLED; pair < ccgen_words16(rows); ++pair) {
        ccgen_prepare16(rows, zero, counts, pair, &factors);
    }
    uint32_t all = 0;
    for (uint8_t i = 0; i < check->kept; ++i) {
        all |= ccgen_parity16(rows, &factors, &row);
    }
    return ((all >> check->quiet_bits) >> 1) == 0u;
}

/** Finds parity values from the first on, in 16 bits. \return bits that they lost more. */
static inline uint8_t ccgen_shortened16(const ccgen_check_t *const check,
                                        const int32_t *const parity, const uint8_t values,
                                        int16_t *const shortened) {
    uint32_t sizes = 0;
    for (uint8_t i = 0; i < values; ++i) {
        sizes |= (uint32_t)(parity[i] < 0 ? -(parity[i] + 1) : parity[i]);
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
static inline void ccgen_values16(const ccgen_axis16_t *const rows,
                                  const ccgen_factors16_t *const factors,
                                  const uint32_t **const row, int32_t *const parity,
                                  const uint8_t values) {
    for (uint8_t i = 0; i < values; ++i) {
        uint32_t sum = factors->start;
        for (uint8_t pair = 0; pair < ccgen_words16(rows); ++pair) {
            sum = ccgen_add_pair16(rows, sum, ccgen_load(row), factors, pair);
        }
        parity[i] = ccgen_signed32(sum);
    }
}

/** \return the verdict over a snapshot that is not quiet, with code that serves every group. */
CCGEN_INLINE uint8_t ccgen_examine16(const ccgen_axis16_t *const rows,
                                     const ccgen_check_t *const check, const int16_t *const zero,
                                     const int16_t *const counts) {
    int32_t parity[CCGEN_SENSORS_MAX];
    int16_t shortened[CCGEN_SENSORS_MAX];
    uint32_t size[CCGEN_SENSORS_MAX];
    const uint32_t *row = rows->rows;
    const uint8_t kept = check->kept;
    ccgen_factors16_t factors = CCGEN_ZERO;
    for (uint8_t pair = 0; pair < ccgen_words16(rows); ++pair) {
        ccgen_prepare16(rows, zero, counts, pair, &factors);
    }
    ccgen_values16(rows, &factors, &row, parity, kept);
    uint8_t more = ccgen_shortened16(check, parity, kept, shortened);
    ccgen_residuals(check, shortened, kept, size);
    if (!ccgen_alarms(check, size, more)) {
        return CCGEN_VERDICT_QUIET;
    }
    ccgen_values16(rows, &factors, &row, parity + kept, (uint8_t)(check->sensors - kept));
    more = ccgen_shortened16(check, parity, check->sensors, shortened);
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
CCGEN_INLINE bool ccgen_check16(const ccgen_axis16_t *const rows, const ccgen_check_t *const check,
                                const int16_t *const zero, const int16_t *const counts) {
    const bool narrow = ccgen_fits_halves16(rows, zero, counts);
#if CCGEN_SMALL
    return ccgen_quiet16(rows, check, zero, counts, narrow);
#else
    return narrow ? ccgen_quiet16(rows, check, zero, counts, true)
                  : ccgen_quiet16(rows, check, zero, counts, false);
#endif
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CHECK16_H */
