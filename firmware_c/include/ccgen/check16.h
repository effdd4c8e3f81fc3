/**
 * \file check16.h
 * \brief Holds a group of sensors against each other, with 16-bit counts and weights.
 *
 *     z_j = sum_k W_jk (count_k - zero_k)
 *
 * A snapshot alarms where some |z_j| exceeds its threshold; the alarm names the sensor of the
 * largest |z_j| where that exceeds all others by more than its margin. The exporter proves that no
 * |z_j| and no partial sum reaches 2^31 for differences in range. The products are those of
 * estimator16.h; a snapshot that does not alarm, the common case, takes no more than them and a
 * comparison a sensor.
 */
#ifndef CCGEN_CHECK16_H
#define CCGEN_CHECK16_H

#include "ccgen/kernel16.h"
#include "ccgen/watch.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The check of one group: lives in flash. */
typedef struct {
    const int32_t *threshold; /**< [sensors] 0 or more */
    const int32_t *margin;    /**< [sensors] 0 or more */
} ccgen_check16_t;

/** \return |z| of one row, which moves on to the next. */
CCGEN_INLINE uint32_t ccgen_residual16(const ccgen_axis16_t *const rows,
                                       const ccgen_factors16_t *const factors,
                                       const uint32_t **const row) {
    uint32_t sum = factors->start;
    if (rows->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t pair = 0; pair < ccgen_words16(rows); ++pair) {
            sum = ccgen_add_pair16(rows, sum, ccgen_load(row), factors, pair);
        }
    } else {
        sum = ccgen_add_pairs16(rows, sum, factors, row, 0);
        sum = ccgen_add_pairs16(rows, sum, factors, row, 1);
    }
    return (sum < 0x80000000u) ? sum : (0u - sum);
}

/** \return the verdict over the sizes of all residuals of a snapshot that alarms. */
CCGEN_INLINE uint8_t ccgen_named16(const ccgen_check16_t *const check, const uint32_t *const size,
                                   const uint8_t sensors) {
    uint32_t largest = size[0];
    uint32_t second = 0;
    uint8_t first = 0;
    for (uint8_t j = 1; j < sensors; ++j) {
        if (size[j] > largest) {
            second = largest;
            largest = size[j];
            first = j;
        } else if (size[j] > second) {
            second = size[j];
        }
    }
    return ((largest - second) > (uint32_t)check->margin[first]) ? first : CCGEN_VERDICT_UNNAMED;
}

/**
 * Takes the verdict of a snapshot.
 * \param[in] rows    W, as the rows of an axis with as many segments as sensors, whose bias and
 *                    shift are 0 and which does not saturate
 * \param[in] check
 * \param[in] zero    [sensors] counts at the straight pose
 * \param[in] counts  [sensors] every one a reading
 * \return number of the sensor that is named, CCGEN_VERDICT_UNNAMED or CCGEN_VERDICT_QUIET
 */
CCGEN_INLINE uint8_t ccgen_check16(const ccgen_axis16_t *const rows,
                                   const ccgen_check16_t *const check, const int16_t *const zero,
                                   const int16_t *const counts) {
    uint32_t size[CCGEN_SENSORS_MAX];
    const uint32_t *row = rows->rows;
    bool alarm = false;
    ccgen_factors16_t factors = CCGEN_ZERO;
    factors.narrow = ccgen_fits_halves16(rows, zero, counts);
    factors.start = ccgen_start16(rows);
    for (uint8_t pair = 0; pair < ccgen_words16(rows); ++pair) {
        ccgen_prepare16(rows, zero, counts, pair, &factors);
    }
    for (uint8_t j = 0; j < rows->sensors; ++j) {
        size[j] = ccgen_residual16(rows, &factors, &row);
        alarm = alarm || (size[j] > (uint32_t)check->threshold[j]);
    }
    return alarm ? ccgen_named16(check, size, rows->sensors) : CCGEN_VERDICT_QUIET;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CHECK16_H */
