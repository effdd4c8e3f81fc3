/**
 * \file watch.h
 * \brief What verdicts of a check do to a group of sensors over time.
 *
 * A sensor that CCGEN_OUT_AFTER snapshots in a row name is left out from the last of them on: it
 * counts as without a reading. It comes back with the last of CCGEN_BACK_AFTER snapshots in a row
 * that do not speak against it: without an alarm, or with one that names another. Snapshots in
 * which a sensor of the group has no reading begin all counting anew, and leave out who is.
 *
 * State belongs to the caller; constant time; no int wider than 16 bits is assumed.
 */
#ifndef CCGEN_WATCH_H
#define CCGEN_WATCH_H

#include "ccgen/check.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Snapshots in a row that name a sensor until it is left out. */
#define CCGEN_OUT_AFTER 3u

/** Snapshots in a row that do not speak against a sensor until it comes back. */
#define CCGEN_BACK_AFTER 20u

/** In the place of a sensor's number: nobody. */
#define CCGEN_NOBODY 0xFFu

/** Verdicts of a check: the number of the sensor that an alarm names, or one of these. */
#define CCGEN_VERDICT_UNNAMED 0xFEu /**< an alarm that names nobody */
#define CCGEN_VERDICT_QUIET 0xFFu   /**< no alarm */

/** State of a group of sensors, owned by the caller. */
typedef struct {
    uint8_t sensor; /**< in the group: the one that was named last, or is left out; or nobody */
    uint8_t run;    /**< snapshots in a row that speak for a change */
    bool out;       /**< the sensor is left out */
} ccgen_watch_t;

/** Sets the state to: nobody is suspected. */
CCGEN_INLINE void ccgen_watch_init(ccgen_watch_t *const watch) {
    watch->sensor = CCGEN_NOBODY;
    watch->run = 0;
    watch->out = false;
}

/** Takes note of a snapshot in which some sensor of the group has no reading. */
CCGEN_INLINE void ccgen_watch_incomplete(ccgen_watch_t *const watch) {
    watch->run = 0;
    watch->sensor = watch->out ? watch->sensor : CCGEN_NOBODY;
}

/** Follows a complete snapshot while a sensor is left out. */
CCGEN_INLINE void ccgen_watch_leaving(ccgen_watch_t *const watch, const uint8_t verdict) {
    if ((verdict == watch->sensor) || (verdict == CCGEN_VERDICT_UNNAMED)) {
        watch->run = 0;
        return;
    }
    watch->run = CCGEN_CAST(uint8_t, watch->run + 1u);
    if (watch->run == CCGEN_BACK_AFTER) {
        ccgen_watch_init(watch);
    }
}

/**
 * Follows a complete snapshot.
 * \param[in,out] watch
 * \param[in] verdict  of the check
 */
CCGEN_INLINE void ccgen_watch_follow(ccgen_watch_t *const watch, const uint8_t verdict) {
    if (watch->out) {
        ccgen_watch_leaving(watch, verdict);
    } else if (verdict >= CCGEN_VERDICT_UNNAMED) {
        ccgen_watch_init(watch);
    } else {
        watch->run = (verdict == watch->sensor) ? CCGEN_CAST(uint8_t, watch->run + 1u) : 1u;
        watch->sensor = verdict;
        if (watch->run == CCGEN_OUT_AFTER) {
            watch->run = 0;
            watch->out = true;
        }
    }
}

/** \return the sensors of the group that are left out: a mask, bit j for sensor j. */
CCGEN_INLINE uint16_t ccgen_watch_out(const ccgen_watch_t *const watch) {
    return CCGEN_CAST(uint16_t, watch->out ? (UINT32_C(1) << watch->sensor) : 0u);
}

/**
 * Tells who is suspected after a snapshot: the sensor that is left out; while none is, the one that
 * the verdict names.
 * \param[in] watch
 * \param[in] verdict  CCGEN_VERDICT_QUIET where the snapshot was not complete
 * \return mask, bit j for sensor j of the group
 */
CCGEN_INLINE uint16_t ccgen_watch_suspected(const ccgen_watch_t *const watch,
                                            const uint8_t verdict) {
    const uint8_t sensor = watch->out ? watch->sensor : verdict;
    const uint32_t mask = (sensor >= CCGEN_VERDICT_UNNAMED) ? 0u : (UINT32_C(1) << sensor);
    return CCGEN_CAST(uint16_t, mask);
}

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_WATCH_H */
