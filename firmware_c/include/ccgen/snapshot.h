/**
 * \file snapshot.h
 * \brief Assembles the LENGTHS frames of one sending into a coherent snapshot of counts.
 *
 * All frames of a sending carry one number (see layout.h). Counts come out only when every frame of
 * one number has arrived, unharmed, within the window; old and new readings never mix. What is
 * wrong with the traffic is counted and flagged:
 *
 * - check value wrong -> corrupted; kind, length or counter impossible -> malformed; both ignored.
 * - The number of the newest snapshot: a frame whose place is taken by the same counts -> repeated.
 *   If it is taken by other counts, another sending has come round to the number or a sender has
 *   started anew with it: a new snapshot begins, and one that was incomplete is lost.
 * - Ahead of the newest by less than half the numbers: a newer snapshot begins. One that was still
 *   incomplete is lost, and every number skipped is one lost.
 * - Otherwise the frame is from the past -> reordered, ignored.
 * - A frame that arrives more than the window after its snapshot's first: the snapshot is late, and
 *   dropped whole.
 * - At the start, and after silence of more than three cycles (or the window, if that is longer),
 *   any number begins a snapshot: a sender may start anew. An incomplete one is then lost. Frames
 *   from the past do not break the silence; repeated ones do.
 *
 * What the bus owes in return, so that one number within one window is one sending:
 *
 * - A sender advances its number by one a sending, and sends once a cycle at most, on average.
 * - No frame arrives half the numbers of cycles or more after it was sent: 120 (128 on CAN FD, 8
 *   without the turn).
 * - A sender that starts anew first keeps silent for a window, counted from the last frame of its
 *   former self, or begins with a number that the bus has not just seen: it goes on from its last
 *   one, ahead of the cycles that have passed by at most 20 in any 220 (28 in 228 on CAN FD, 1 in
 *   14 without the turn).
 *
 * State belongs to the caller; one context at a time works on it. Time is a free-running 32-bit
 * count of microseconds that wraps. A time less than 2^31 us behind the latest that was told counts
 * as that latest, so that stamps may come out of order; in return some function that takes the time
 * is called at least every 30 minutes. One frame takes time in proportion to its bytes and, when it
 * completes a snapshot, to the number of counts.
 */
#ifndef CCGEN_SNAPSHOT_H
#define CCGEN_SNAPSHOT_H

#include "ccgen/layout.h"

/** Fault flags of the status frame. They accumulate until a status frame that was sent has carried
 * them. */
enum {
    CCGEN_FAULT_CRC = 0x01,       /**< a LENGTHS frame whose check value was wrong; ignored */
    CCGEN_FAULT_FORMAT = 0x02,    /**< one that had a wrong kind, length or counter; ignored */
    CCGEN_FAULT_REPEATED = 0x04,  /**< one that was there already; ignored */
    CCGEN_FAULT_REORDERED = 0x08, /**< one that was older than the newest snapshot; ignored */
    CCGEN_FAULT_LOST = 0x10,      /**< an incomplete snapshot, or numbers that were skipped */
    CCGEN_FAULT_LATE = 0x20,      /**< a snapshot's frames spread over more than the window */
    CCGEN_FAULT_MISSING = 0x40,   /**< a sensor's count was out of its range */
    CCGEN_FAULT_STALE = 0x80      /**< no complete snapshot for more than three cycles */
};

/** An age in the status frame of this or more milliseconds, or no snapshot ever. */
#define CCGEN_AGE_MAX_MS 255u

/** A time that seems so far ahead or more lies behind. */
#define CCGEN_BEHIND_US 0x80000000u

/** What becomes of frames that carry the newest number. */
typedef enum {
    CCGEN_SNAPSHOT_NONE,     /**< no number is known: the next frame begins a snapshot */
    CCGEN_SNAPSHOT_PENDING,  /**< being assembled */
    CCGEN_SNAPSHOT_COMPLETE, /**< complete */
    CCGEN_SNAPSHOT_DROPPED   /**< was late */
} ccgen_snapshot_phase_t;

/** State, owned by the caller; the fields up to `number` are for reading, the rest is internal. */
typedef struct {
    int32_t counts[CCGEN_SENSORS_MAX]; /**< latest complete snapshot, in the joint's order */
    uint32_t snapshots;               /**< complete ones */
    uint32_t corrupted;               /**< frames */
    uint32_t malformed;               /**< frames */
    uint32_t repeated;                /**< frames */
    uint32_t reordered;               /**< frames */
    uint32_t lost;                    /**< snapshots */
    uint32_t late;                    /**< snapshots */
    uint8_t number;                   /**< of the latest complete snapshot */

    int32_t pending[CCGEN_SENSORS_MAX];
    uint32_t window_us;
    uint32_t window_max_us;
    uint32_t stale_us;   /* without a complete snapshot */
    uint32_t silence_us; /* after which any number begins one */
    uint32_t now_us; /* the latest time that was told */
    uint32_t first_us;
    uint32_t heard_us;
    uint32_t complete_us;
    uint16_t received;
    uint8_t newest;
    uint8_t faults; /* not carried yet by a status that was sent */
    uint8_t recent; /* those among them that are newer than the last status handed out */
    ccgen_snapshot_phase_t phase;
    bool started;
    bool stale;
    bool aged;
} ccgen_snapshot_t;

/**
 * Takes the time without noticing silence.
 * \param[in,out] snapshot
 * \param[in] now_us
 * \return whether a time was told before; otherwise it is not taken
 */
CCGEN_INLINE bool ccgen_snapshot_pass(ccgen_snapshot_t *const snapshot, const uint32_t now_us) {
    if (snapshot->started && ((now_us - snapshot->now_us) < CCGEN_BEHIND_US)) {
        snapshot->now_us = now_us;
    }
    return snapshot->started;
}

#endif /* CCGEN_SNAPSHOT_H */
