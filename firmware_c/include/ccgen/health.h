/**
 * \file health.h
 * \brief What the HEALTH frame tells: which model this is, its sensors, axes, zero, last command.
 *
 * HEALTH goes out every 100 ms and after each command, and counts itself. Its payload, behind the
 * E2E header: fingerprint of the model (16 bits), sensors suspected (16), states of the axes u, v
 * and h (2 each), whose zero this is (2), number (4) and result (4) of the last command.
 *
 * State belongs to the caller; the node keeps one. All functions take constant time and accept
 * only layouts that ccgen_layout_valid() accepts.
 */
#ifndef CCGEN_HEALTH_H
#define CCGEN_HEALTH_H

#include "ccgen/layout.h"
#include "ccgen/zero.h"

/** Longest time between two HEALTH frames. */
#define CCGEN_HEALTH_US 100000u

/** States of an output axis: two bits each in a mask, u in bits 0 and 1, then v, then h. */
#define CCGEN_AXIS_DEGRADED 1u
#define CCGEN_AXIS_LOST 2u

/** The state of an axis in a mask; `axis` is 0 for u, 1 for v, 2 for h. */
#define CCGEN_AXIS_STATE(mask, axis) (((mask) >> (2u * (axis))) & 3u)

/** What became of the last command. Unless it is done, nothing has changed. */
typedef enum {
    CCGEN_RESULT_NONE,    /**< no command yet */
    CCGEN_RESULT_DONE,    /**< done */
    CCGEN_RESULT_BUSY,    /**< a capture goes on */
    CCGEN_RESULT_SILENCE, /**< no complete snapshot for a second */
    CCGEN_RESULT_MOVING,  /**< the joint moved */
    CCGEN_RESULT_RANGE,   /**< a reading is too near an end of its range for a zero */
    CCGEN_RESULT_UNKNOWN, /**< no such command, or no snapshots */
    CCGEN_RESULT_NOTHING  /**< no zero was restored that could be gone back to */
} ccgen_result_t;

/** State, owned by the caller; the fields up to `result` are what is told, the rest is internal. */
typedef struct {
    uint16_t suspected;    /**< sensors, as in the STATUS frame's mask of those missing */
    uint8_t axes;          /**< states of the axes in the latest snapshot, as above */
    ccgen_zero_t zero;     /**< whose offsets the estimator works with */
    uint8_t command;       /**< number of the last command, 0 to 15 */
    ccgen_result_t result; /**< of the last command */

    uint32_t sent_us;
    uint8_t counter;
    bool due; /* whatever the time */
} ccgen_health_t;

#endif /* CCGEN_HEALTH_H */
