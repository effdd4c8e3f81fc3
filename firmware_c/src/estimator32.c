#include "ccgen/estimator32.h"

/** \return bias and products of one segment, modulo 2^64 */
static uint64_t sum_of(const ccgen_axis32_t *const axis, const uint16_t segment,
                       const int32_t *const zero, const int32_t *const counts) {
    const int32_t *const weights = &axis->weights[(size_t)segment * axis->sensors];
    uint64_t sum = (uint64_t)axis->bias[segment];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const int32_t difference = ccgen_signed32((uint32_t)counts[j] - (uint32_t)zero[j]);
        sum += (uint64_t)((int64_t)weights[j] * difference);
    }
    return sum;
}

void ccgen_axis32_evaluate_any(const ccgen_axis32_t *const axis, const int32_t *const zero,
                               const int32_t *const counts, int32_t *const angles) {
    for (uint16_t i = 0; i < axis->segments; ++i) {
        int64_t angle = ccgen_signed64(sum_of(axis, i, zero, counts)) >> axis->shift;
        angle = (angle < CCGEN_ANGLE32_LIMIT) ? angle : CCGEN_ANGLE32_LIMIT;
        angle = (angle > -CCGEN_ANGLE32_LIMIT) ? angle : -CCGEN_ANGLE32_LIMIT;
        angles[i] = (int32_t)angle;
    }
}
