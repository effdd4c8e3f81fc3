#include "sample.h"

#include "ccgen/estimator16.h"
#include "ccgen/sensors16.h"

/* Axis u saturates within its range and is narrow; axis v does neither. */
static const int16_t u_minimum[3] CCGEN_FLASH = {-10000, -9000, -10000};
static const int16_t u_maximum[3] CCGEN_FLASH = {10000, 12000, 10000};
static const int16_t u_zero[3] CCGEN_FLASH = {12, -7, 0};
static const int32_t u_biases[SAMPLE_SEGMENTS] = {
    0, 700, 1400, 2100, 2800, 3500, 4200, 4900, 5600, 6300, 7000, 7700,
};
static const uint32_t u_rows[SAMPLE_SEGMENTS * 2] = {
    CCGEN_PAIR(7547, 1673), CCGEN_PAIR(-5402, 0),
    CCGEN_PAIR(8333, 3708), CCGEN_PAIR(-3579, 0),
    CCGEN_PAIR(8600, 5513), CCGEN_PAIR(-1533, 0),
    CCGEN_PAIR(8333, 6974), CCGEN_PAIR(608, 0),
    CCGEN_PAIR(7547, 8002), CCGEN_PAIR(2712, 0),
    CCGEN_PAIR(6293, 8533), CCGEN_PAIR(4647, 0),
    CCGEN_PAIR(4647, 8533), CCGEN_PAIR(6293, 0),
    CCGEN_PAIR(2712, 8002), CCGEN_PAIR(7547, 0),
    CCGEN_PAIR(608, 6974), CCGEN_PAIR(8333, 0),
    CCGEN_PAIR(-1533, 5513), CCGEN_PAIR(8600, 0),
    CCGEN_PAIR(-3579, 3708), CCGEN_PAIR(8333, 0),
    CCGEN_PAIR(-5402, 1673), CCGEN_PAIR(7547, 0),
};

static const int16_t v_minimum[3] CCGEN_FLASH = {-20000, -20000, -20000};
static const int16_t v_maximum[3] CCGEN_FLASH = {20000, 20000, 20000};
static const int16_t v_zero[3] CCGEN_FLASH = {0, 0, 0};
/* clang-format off */
static const int32_t v_biases[SAMPLE_SEGMENTS] = {
    0, -300, -600, -900, -1200, -1500, -1800, -2100, -2400, -2700, -3000, -3300,
};
static const uint32_t v_rows[SAMPLE_SEGMENTS * 2] = {
    CCGEN_PAIR(921, 204), CCGEN_PAIR(-660, 0),
    CCGEN_PAIR(1017, 453), CCGEN_PAIR(-437, 0),
    CCGEN_PAIR(1050, 673), CCGEN_PAIR(-187, 0),
    CCGEN_PAIR(1017, 852), CCGEN_PAIR(74, 0),
    CCGEN_PAIR(921, 977), CCGEN_PAIR(331, 0),
    CCGEN_PAIR(768, 1042), CCGEN_PAIR(567, 0),
    CCGEN_PAIR(567, 1042), CCGEN_PAIR(768, 0),
    CCGEN_PAIR(331, 977), CCGEN_PAIR(921, 0),
    CCGEN_PAIR(74, 852), CCGEN_PAIR(1017, 0),
    CCGEN_PAIR(-187, 673), CCGEN_PAIR(1050, 0),
    CCGEN_PAIR(-437, 453), CCGEN_PAIR(1017, 0),
    CCGEN_PAIR(-660, 204), CCGEN_PAIR(921, 0),
};
/* clang-format on */

static const ccgen_axis16_t u_axis = {
    SAMPLE_SEGMENTS, SAMPLE_SENSORS_U, 12, SAMPLE_FRACTION_BITS_U, true, true, -2152, u_biases,
    u_rows,
};

static const ccgen_sensors16_t u_sensors = {
    SAMPLE_SENSORS_U, u_minimum, u_maximum, u_zero, NULL, NULL, u_minimum, u_maximum,
};

static const ccgen_axis16_t v_axis = {
    SAMPLE_SEGMENTS, SAMPLE_SENSORS_V, 12, SAMPLE_FRACTION_BITS_V, false, false, 3848, v_biases,
    v_rows,
};

static const ccgen_sensors16_t v_sensors = {
    SAMPLE_SENSORS_V, v_minimum, v_maximum, v_zero, NULL, NULL, v_minimum, v_maximum,
};

int sample_init(sample_t *const joint) {
    if (joint == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    for (uint8_t j = 0; j < SAMPLE_SENSORS_U; ++j) {
        joint->zero.u[j] = CCGEN_FLASH_INT16(&u_zero[j]);
    }
    for (uint8_t j = 0; j < SAMPLE_SENSORS_V; ++j) {
        joint->zero.v[j] = CCGEN_FLASH_INT16(&v_zero[j]);
    }
    return CCGEN_OK;
}

int sample_capture_zero(sample_t *const joint, const sample_counts_t *const counts) {
    if ((joint == NULL) || (counts == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (sample_missing(joint, counts) != 0) {
        return CCGEN_ERROR_MISSING;
    }
    joint->zero = *counts;
    return CCGEN_OK;
}

int sample_restore_zero(sample_t *const joint, const sample_counts_t *const zero) {
    return sample_capture_zero(joint, zero);
}

int sample_estimate(const sample_t *const joint, const sample_counts_t *const counts,
                    sample_angles_t *const angles) {
    if ((joint == NULL) || (counts == NULL) || (angles == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    if (sample_missing(joint, counts) != 0) {
        return CCGEN_ERROR_MISSING;
    }
    ccgen_axis16_evaluate(&u_axis, joint->zero.u, counts->u, angles->u);
    ccgen_axis16_evaluate(&v_axis, joint->zero.v, counts->v, angles->v);
    return CCGEN_OK;
}

int32_t sample_missing(const sample_t *const joint, const sample_counts_t *const counts) {
    if ((joint == NULL) || (counts == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const int32_t u = ccgen_sensors16_missing(&u_sensors, joint->zero.u, counts->u);
    const int32_t v = ccgen_sensors16_missing(&v_sensors, joint->zero.v, counts->v);
    return u + v * 256;
}
