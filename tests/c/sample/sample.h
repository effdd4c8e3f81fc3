/**
 * \file sample.h
 * \brief A small made-up joint in the shape of exported code: the test bed of the C runtime.
 */
#ifndef SAMPLE_H
#define SAMPLE_H

#include <stdint.h>

#include "ccgen/error.h"
#include "ccgen/version.h"

#if CCGEN_FORMAT_VERSION != 3
#error "sample.h needs the ccgen runtime of format 3"
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define SAMPLE_SEGMENTS 12
#define SAMPLE_SENSORS_U 3
#define SAMPLE_SENSORS_V 3
#define SAMPLE_SENSORS (SAMPLE_SENSORS_U + SAMPLE_SENSORS_V)
#define SAMPLE_VALUES (2 * SAMPLE_SEGMENTS)
#define SAMPLE_PRECISION 16
#define SAMPLE_FRACTION_BITS_U 18
#define SAMPLE_FRACTION_BITS_V 18

typedef int16_t sample_count_t;
typedef int16_t sample_angle_t;

typedef struct {
    sample_count_t u[SAMPLE_SENSORS_U];
    sample_count_t v[SAMPLE_SENSORS_V];
} sample_counts_t;

typedef struct {
    sample_angle_t u[SAMPLE_SEGMENTS];
    sample_angle_t v[SAMPLE_SEGMENTS];
} sample_angles_t;

typedef struct {
    sample_counts_t zero;
} sample_t;

int sample_init(sample_t *joint);
int sample_capture_zero(sample_t *joint, const sample_counts_t *counts);
int sample_restore_zero(sample_t *joint, const sample_counts_t *zero);
int sample_estimate(const sample_t *joint, const sample_counts_t *counts, sample_angles_t *angles);
int32_t sample_missing(const sample_t *joint, const sample_counts_t *counts);

#ifdef __cplusplus
}
#endif

#endif /* SAMPLE_H */
