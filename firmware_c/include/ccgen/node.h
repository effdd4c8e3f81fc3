/**
 * \file node.h
 * \brief A joint's node on the bus: counts in, angles, tip and status out.
 *
 * The generated NAME_can.c wraps this for one joint: it hands frames to ccgen_node_receive(), and
 * when a snapshot is complete takes the counts, estimates, and calls ccgen_node_publish(). Frames
 * go out one a call of ccgen_node_transmit16() or ccgen_node_transmit32(), whichever fits the
 * joint's precision: all ANGLES frames and TIP of a snapshot under that snapshot's number, STATUS
 * whenever a cycle has passed, and HEALTH (see health.h); of these what the layout publishes.
 *
 * An axis that its sensors do not suffice for goes out with "no reading" in every signal, TIP too
 * while any axis is lost; HEALTH says which axis, and the status which sensor is missing. Call
 * transmit until it returns 0 after every received frame: an estimate whose frames were not all
 * fetched when the next one comes is dropped and counted in `overruns`.
 *
 * A frame that was handed out counts as sent at the next call of transmit; until then
 * ccgen_node_unsent() takes it back. The faults that a STATUS frame carries are forgotten once it
 * counts as sent, and not before.
 *
 * State belongs to the caller, and one context at a time works on it: an interrupt that receives
 * frames hands them over (see queue.h). Times are those of snapshot.h. No heap, no globals, no
 * float.
 */
#ifndef CCGEN_NODE_H
#define CCGEN_NODE_H

#include "ccgen/health.h"
#include "ccgen/layout.h"
#include "ccgen/snapshot.h"

/** What was handed out last and may still be taken back. */
typedef enum {
    CCGEN_HANDED_NOTHING,
    CCGEN_HANDED_ESTIMATE,
    CCGEN_HANDED_STATUS,
    CCGEN_HANDED_HEALTH
} ccgen_handed_t;

/** What angles are worth, from best to worst. */
enum {
    CCGEN_ANGLES_GOOD = 0,     /**< fresh, and every axis is good */
    CCGEN_ANGLES_DEGRADED = 1, /**< fresh; some axis is degraded or lost */
    CCGEN_ANGLES_LOST = 2,     /**< there are none: no snapshot yet, or the latest had too little */
    CCGEN_ANGLES_STALE = 3     /**< there are none any more: the latest is over three cycles old */
};

/** State, owned by the caller; the fields up to `missing` are for reading, the rest is internal. */
typedef struct {
    ccgen_snapshot_t snapshot;
    ccgen_health_t health;
    uint32_t estimates; /**< snapshots that were estimated */
    uint32_t failures;  /**< snapshots without an estimate */
    uint32_t overruns;  /**< snapshots replaced before all their frames were fetched */
    uint16_t missing;   /**< sensors without a reading in the latest snapshot, as published */

    uint32_t status_us;
    uint32_t status_wait_us;
    uint32_t looked_us; /* when it was noticed last how long ago things are */
    uint16_t next;
    int16_t tip[3];
    uint8_t published;
    uint8_t status_counter;
    ccgen_handed_t handed;
    bool status_again; /* it was taken back */
    bool estimated;
} ccgen_node_t;

#endif /* CCGEN_NODE_H */
