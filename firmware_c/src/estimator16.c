#include "ccgen/estimator16.h"

/** \return bias and products of one segment, modulo 2^32 */
static uint32_t sum_of(const ccgen_axis16_t *const axis, const uint32_t *const row,
                       const int16_t *const zero, const int16_t *const counts) {
    uint32_t sum = row[0];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const uint32_t pair = row[1u + j / 2u];
        const int32_t weight = ((j % 2u) == 0u) ? ccgen_low16(pair) : ccgen_high16(pair);
        sum += (uint32_t)(weight * ((int32_t)counts[j] - (int32_t)zero[j]));
    }
    return sum;
}

void ccgen_axis16_evaluate_any(const ccgen_axis16_t *const axis, const int16_t *const zero,
                               const int16_t *const counts, int16_t *const angles) {
    const size_t words = 1u + ((size_t)axis->sensors + 1u) / 2u;
    const uint32_t *row = axis->rows;
    for (uint16_t i = 0; i < axis->segments; ++i) {
        const int32_t angle = ccgen_signed32(sum_of(axis, row, zero, counts)) >> axis->shift;
        angles[i] = ccgen_low16((uint32_t)ccgen_axis16_saturate(angle));
        row += words;
    }
}
