/**
 * \file capture.h
 * \brief A zero captured as the average of several snapshots of the straight joint at rest.
 *
 * Snapshots in which a sensor has no reading within its range do not count. The capture fails when
 * a sensor reads farther from where it began than noise explains (the joint moves), and when no
 * snapshot that counts has come for a second, or for three cycles where that is longer.
 *
 * State belongs to the caller. One snapshot takes time in proportion to the number of sensors; the
 * last one divides once for each of them, in 32 bits.
 */
#ifndef CCGEN_CAPTURE_H
#define CCGEN_CAPTURE_H

#include "ccgen/health.h"
#include "ccgen/snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Longest time without a snapshot that counts. */
#define CCGEN_CAPTURE_US 1000000u

/** What a joint's sensors can count; lives in flash, tables CCGEN_FLASH with an element a sensor. */
typedef struct {
    uint8_t sensors;
    const int32_t *minimum; /**< of a reading, counts */
    const int32_t *maximum; /**< of a reading, counts */
    const int32_t *still;   /**< how far a reading at rest may stray, counts; 0 to 2^22 */
} ccgen_capture_limits_t;

/** State, owned by the caller; `zero` is for reading when the capture is done. */
typedef struct {
    int32_t zero[CCGEN_SENSORS_MAX]; /**< average, counts; before that where each sensor began */

    int32_t sum[CCGEN_SENSORS_MAX]; /* of the distances from there */
    uint32_t heard_us;
    uint32_t patience_us;
    uint8_t wanted;
    uint8_t taken;
    bool began;
} ccgen_capture_t;

/**
 * Begins a capture. The latest snapshot, where it is fresh, serves to see whether the joint moves.
 * \param[in] layout
 * \param[in] limits
 * \param[out] capture
 * \param[in] snapshot   of the node
 * \param[in] snapshots  to average, 1 to 255
 */
void ccgen_capture_begin(const ccgen_layout_t *layout, const ccgen_capture_limits_t *limits,
                         ccgen_capture_t *capture, const ccgen_snapshot_t *snapshot,
                         uint8_t snapshots);

/**
 * Takes a complete snapshot.
 * \return CCGEN_RESULT_BUSY: another is needed; CCGEN_RESULT_DONE: the average stands in `zero`;
 *         CCGEN_RESULT_MOVING: it failed
 */
ccgen_result_t ccgen_capture_take(const ccgen_capture_limits_t *limits, ccgen_capture_t *capture,
                                  const ccgen_snapshot_t *snapshot);

/** \return CCGEN_RESULT_BUSY, or CCGEN_RESULT_SILENCE: it failed, for nothing comes. */
ccgen_result_t ccgen_capture_wait(const ccgen_capture_t *capture, uint32_t now_us);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_CAPTURE_H */
