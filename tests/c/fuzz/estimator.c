/**
 * \file estimator.c
 * \brief Fuzzes both estimators with any model, counts and zero offsets.
 *
 * Nothing is undefined whatever the input. Where the true sum fits the accumulator, as the
 * exporter proves for its own models, the angle is that of a plain computation in wider integers.
 */
#include "ccgen/estimator16.h"
#include "ccgen/estimator32.h"
#include "ccgen/sensors16.h"
#include "ccgen/sensors32.h"

#include <string.h>

#include "input.h"

#define MARK 0x5A

/** One axis in the widest terms. */
typedef struct {
    uint16_t segments;
    uint8_t sensors;
    uint8_t shift;
    bool saturates;
    bool common;   /* one bias for all segments */
    bool relative; /* differences have a range of their own */
    int32_t minimum[CCGEN_SENSORS_MAX];
    int32_t maximum[CCGEN_SENSORS_MAX];
    int32_t difference_minimum[CCGEN_SENSORS_MAX];
    int32_t difference_maximum[CCGEN_SENSORS_MAX];
    int32_t counts[CCGEN_SENSORS_MAX];
    int32_t zero[CCGEN_SENSORS_MAX];
    int64_t bias[CCGEN_SEGMENTS_MAX];
    int32_t weights[CCGEN_SEGMENTS_MAX][CCGEN_SENSORS_MAX];
} axis_t;

__extension__ typedef __int128 wide_t;

/** \return the most negative value of `bits` bits. */
static int64_t lowest(const uint8_t bits) {
    return -(int64_t)(UINT64_MAX >> (65u - bits)) - 1;
}

/** A value of `bits` bits; small ones often, and the corners. */
static int64_t draw(input_t *const input, const uint8_t bits) {
    const uint8_t how = take8(input);
    const int64_t largest = (int64_t)(UINT64_MAX >> (65u - bits));
    switch (how & 7u) {
        case 0:
            return 0;
        case 1:
            return lowest(bits);
        case 2:
            return -largest;
        case 3:
            return largest;
        default: {
            const uint8_t drop = (uint8_t)((how >> 3) * bits / 32u);
            const int64_t value = ccgen_signed64(take64(input) << (64u - bits)) >> (64u - bits);
            return value >> drop;
        }
    }
}

/** A count that is not "no reading". */
static int32_t draw_reading(input_t *const input, const uint8_t precision) {
    const int64_t count = draw(input, precision);
    return (int32_t)((count == lowest(precision)) ? -count - 1 : count);
}

static void draw_axis(input_t *const input, const uint8_t precision, axis_t *const axis) {
    const uint8_t flags = take8(input);
    axis->segments = (uint16_t)(1u + take8(input) % CCGEN_SEGMENTS_MAX);
    axis->sensors = (uint8_t)(1u + take8(input) % CCGEN_SENSORS_MAX);
    axis->saturates = (flags & 1u) != 0u;
    axis->common = (flags & 2u) != 0u;
    axis->relative = (flags & 4u) != 0u;
    axis->shift = (uint8_t)(take8(input) % (axis->saturates ? (precision + 1u) : 2u * precision));
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const int32_t a = draw_reading(input, precision);
        const int32_t b = draw_reading(input, precision);
        axis->minimum[j] = (a < b) ? a : b;
        axis->maximum[j] = (a < b) ? b : a;
        axis->difference_minimum[j] = (int32_t)-(draw(input, 32) & INT32_MAX);
        axis->difference_maximum[j] = (int32_t)(draw(input, 32) & INT32_MAX);
        axis->counts[j] = (int32_t)draw(input, precision);
        axis->zero[j] = (int32_t)draw(input, precision);
    }
    for (uint16_t i = 0; i < axis->segments; ++i) {
        axis->bias[i] = (axis->common && (i > 0u)) ? axis->bias[0] : draw(input, 2u * precision);
        for (uint8_t j = 0; j < axis->sensors; ++j) {
            axis->weights[i][j] = (int32_t)draw(input, precision);
        }
    }
}

/** \return mask of counts out of range; and of those that are too far from their zero. */
static uint16_t missing(const axis_t *const axis, const bool relative) {
    uint32_t mask = 0;
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        const wide_t difference = (wide_t)axis->counts[j] - axis->zero[j];
        const bool inside =
            (axis->counts[j] >= axis->minimum[j]) && (axis->counts[j] <= axis->maximum[j]);
        const bool near = (difference >= axis->difference_minimum[j]) &&
                          (difference <= axis->difference_maximum[j]);
        mask |= (inside && (near || !relative)) ? 0u : ((uint32_t)1u << j);
    }
    return (uint16_t)mask;
}

/** \return whether a signed type of `bits` bits holds the value. */
static bool fits(const wide_t value, const uint8_t bits) {
    const wide_t limit = (wide_t)1 << (bits - 1u);
    return (value >= -limit) && (value < limit);
}

/** \return whether every zero is a reading and every difference fits `bits` bits. */
static bool differences_fit(const axis_t *const axis, const uint8_t precision, const uint8_t bits) {
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        if ((axis->zero[j] == lowest(precision)) ||
            !fits((wide_t)axis->counts[j] - axis->zero[j], bits)) {
            return false;
        }
    }
    return true;
}

/** Compares an angle with the plain computation, where the model's proof could cover it. */
static void check_angle(const axis_t *const axis, const uint8_t precision, const uint16_t i,
                        const int64_t angle) {
    wide_t sum = axis->bias[i];
    for (uint8_t j = 0; j < axis->sensors; ++j) {
        sum += (wide_t)axis->weights[i][j] * ((wide_t)axis->counts[j] - axis->zero[j]);
    }
    const wide_t limit = ((wide_t)1 << (precision - 1u)) - 1;
    wide_t expected = sum >> axis->shift;
    if (!fits(sum, 2u * precision) || (sum == lowest(2u * precision))) {
        return;
    }
    if (!axis->saturates && !fits(expected, precision)) {
        return;
    }
    if (axis->saturates) {
        expected = (expected > limit) ? limit : (expected < -limit) ? -limit : expected;
    }
    CHECK(angle == (int64_t)expected);
}

static void fuzz16(input_t input) {
    axis_t axis;
    int16_t minimum[CCGEN_SENSORS_MAX];
    int16_t maximum[CCGEN_SENSORS_MAX];
    int16_t counts[CCGEN_SENSORS_MAX];
    int16_t zero[CCGEN_SENSORS_MAX];
    int32_t biases[CCGEN_SEGMENTS_MAX];
    int16_t angles[CCGEN_SEGMENTS_MAX + 1];
    int16_t before[CCGEN_SEGMENTS_MAX + 1];
    uint32_t rows[CCGEN_SEGMENTS_MAX * CCGEN_SENSORS_MAX / 2];
    memset(&axis, 0, sizeof axis);
    draw_axis(&input, 16, &axis);
    for (uint8_t j = 0; j < axis.sensors; ++j) {
        minimum[j] = (int16_t)axis.minimum[j];
        maximum[j] = (int16_t)axis.maximum[j];
        counts[j] = (int16_t)axis.counts[j];
        zero[j] = (int16_t)axis.zero[j];
    }
    const size_t words = (axis.sensors + 1u) / 2u;
    for (uint16_t i = 0; i < axis.segments; ++i) {
        biases[i] = ccgen_signed32((uint32_t)axis.bias[i] - (uint32_t)axis.bias[0]);
        for (size_t k = 0; k < words; ++k) {
            const int32_t low = axis.weights[i][2u * k];
            const int32_t high = axis.weights[i][2u * k + 1u]; /* 0 beyond the last sensor */
            rows[i * words + k] = CCGEN_PAIR(low, high);
        }
    }
    const bool narrow = differences_fit(&axis, 16, 16) && (take8(&input) % 2u == 0u);
    const ccgen_axis16_t model = {
        axis.segments,
        axis.sensors,
        axis.shift,
        10,
        axis.saturates,
        narrow,
        (int32_t)axis.bias[0],
        axis.common ? NULL : biases,
        rows,
    };
    memset(angles, MARK, sizeof angles);
    memcpy(before, angles, sizeof before);
    const ccgen_sensors16_t sensors = {
        axis.sensors,
        minimum,
        maximum,
        zero,
        axis.relative ? axis.difference_minimum : NULL,
        axis.relative ? axis.difference_maximum : NULL,
        minimum,
        maximum,
    };
    const uint16_t mask = missing(&axis, axis.relative);
    CHECK(ccgen_sensors16_missing(&sensors, zero, counts) == mask);
    CHECK(ccgen_sensors16_complete(&sensors, zero, counts) == (mask == 0u));
    const ccgen_range16_t range = {minimum, maximum};
    CHECK(ccgen_outside16(&range, counts, axis.sensors) == missing(&axis, false));
    ccgen_axis16_evaluate(&model, zero, counts, angles);
    const size_t written = axis.segments;
    CHECK(memcmp(&angles[written], &before[written], sizeof angles - written * 2u) == 0);
    for (uint16_t i = 0; (i < written) && differences_fit(&axis, 16, 17); ++i) {
        check_angle(&axis, 16, i, angles[i]);
    }
}

static void fuzz32(input_t input) {
    axis_t axis;
    int64_t biases[CCGEN_SEGMENTS_MAX];
    int32_t angles[CCGEN_SEGMENTS_MAX + 1];
    int32_t before[CCGEN_SEGMENTS_MAX + 1];
    int32_t weights[CCGEN_SEGMENTS_MAX * CCGEN_SENSORS_MAX];
    memset(&axis, 0, sizeof axis);
    draw_axis(&input, 32, &axis);
    for (uint16_t i = 0; i < axis.segments; ++i) {
        biases[i] = ccgen_signed64((uint64_t)axis.bias[i] - (uint64_t)axis.bias[0]);
        for (uint8_t j = 0; j < axis.sensors; ++j) {
            weights[i * axis.sensors + j] = axis.weights[i][j];
        }
    }
    const ccgen_axis32_t model = {
        axis.segments,
        axis.sensors,
        axis.shift,
        10,
        axis.saturates,
        axis.bias[0],
        axis.common ? NULL : biases,
        weights,
    };
    const ccgen_sensors32_t sensors = {
        axis.sensors,
        axis.minimum,
        axis.maximum,
        axis.zero,
        axis.relative ? axis.difference_minimum : NULL,
        axis.relative ? axis.difference_maximum : NULL,
        axis.minimum,
        axis.maximum,
    };
    memset(angles, MARK, sizeof angles);
    memcpy(before, angles, sizeof before);
    const uint16_t mask = missing(&axis, axis.relative);
    CHECK(ccgen_sensors32_missing(&sensors, axis.zero, axis.counts) == mask);
    CHECK(ccgen_sensors32_complete(&sensors, axis.zero, axis.counts) == (mask == 0u));
    const ccgen_range32_t range = {axis.minimum, axis.maximum};
    CHECK(ccgen_outside32(&range, axis.counts, axis.sensors) == missing(&axis, false));
    ccgen_axis32_evaluate(&model, axis.zero, axis.counts, angles);
    const size_t written = axis.segments;
    CHECK(memcmp(&angles[written], &before[written], sizeof angles - written * 4u) == 0);
    for (uint16_t i = 0; (i < written) && differences_fit(&axis, 32, 32); ++i) {
        check_angle(&axis, 32, i, angles[i]);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *const data, const size_t size) {
    input_t input = {data, size};
    if (take8(&input) % 2u == 0u) {
        fuzz16(input);
    } else {
        fuzz32(input);
    }
    return 0;
}
