/**
 * \file check32.h
 * \brief Holds a group of sensors against each other, with 32-bit counts and weights.
 *
 *     z_j = sum_k W_jk (count_k - zero_k)
 *
 * A snapshot alarms where some |z_j| exceeds its threshold; the alarm names the sensor of the
 * largest |z_j| where that exceeds all others by more than its margin. The exporter proves that no
 * |z_j| and no partial sum reaches 2^63 for differences in range. The products are those of
 * estimator32.h; a snapshot that does not alarm, the common case, takes no more than them and a
 * comparison a sensor.
 */
#ifndef CCGEN_CHECK32_H
#define CCGEN_CHECK32_H

#include "ccgen/kernel32.h"
#include "ccgen/watch.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The check of one group: lives in flash. */
typedef struct {
    const int64_t *threshold; /**< [sensors] 0 or more */
    const int64_t *margin;    /**< [sensors] 0 or more */
} ccgen_check32_t;

/** \return |z| of one row, which moves on to the next. */
CCGEN_INLINE uint64_t ccgen_residual32(const ccgen_axis32_t *const rows,
                                       const ccgen_factors32_t *const factors,
                                       const uint32_t **const row) {
    uint64_t sum = 0;
    if (rows->sensors > CCGEN_UNROLLED_MAX) {
        for (uint8_t sensor = 0; sensor < rows->sensors; ++sensor) {
            sum = ccgen_axis32_add(rows, sum, ccgen_load(row), factors, sensor);
        }
    } else {
        sum = ccgen_axis32_add_pair(rows, sum, factors, row, 0);
        sum = ccgen_axis32_add_pair(rows, sum, factors, row, 1);
        sum = ccgen_axis32_add_pair(rows, sum, factors, row, 2);
        sum = ccgen_axis32_add_pair(rows, sum, factors, row, 3);
    }
    return ((sum >> 63) == 0u) ? sum : (0u - sum);
}

/** \return the verdict over the sizes of all residuals of a snapshot that alarms. */
CCGEN_INLINE uint8_t ccgen_named32(const ccgen_check32_t *const check, const uint64_t *const size,
                                   const uint8_t sensors) {
    uint64_t largest = size[0];
    uint64_t second = 0;
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
    return ((largest - second) > (uint64_t)check->margin[first]) ? first : CCGEN_VERDICT_UNNAMED;
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
CCGEN_INLINE uint8_t ccgen_check32(const ccgen_axis32_t *const rows,
                                   const ccgen_check32_t *const check, const int32_t *const zero,
                                   const int32_t *const counts) {
    uint64_t size[CCGEN_SENSORS_MAX];
    const uint32_t *row = (const uint32_t *)rows->weights; /* the unsigned type may alias */
    bool alarm = false;
    ccgen_factors32_t factors = CCGEN_ZERO;
    for (uint8_t j = 0; j < rows->sensors; ++j) {
        factors.difference[j] = ccgen_axis32_difference(rows, zero, counts, j);
    }
    for (uint8_t j = 0; j < rows->sensors; ++j) {
        size[j] = ccgen_residual32(rows, &factors, &row);
        alarm = alarm || (size[j] > (uint64_t)check->threshold[j]);
    }
    return alarm ? ccgen_named32(check, size, rows->sensors) : CCGEN_VERDICT_QUIET;
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CHECK32_H */
