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

#ifdef __cplusplus
extern "C" {
#endif

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
 * Sets the state to: nothing received.
 * \param[in] layout
 * \param[out] snapshot
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or an invalid layout
 */
int ccgen_snapshot_init(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot);

/**
 * Replaces the window of the layout, for transports slower than the bus.
 * \param[in,out] snapshot
 * \param[in] window_us  1 to ccgen_layout_window_max_us()
 * \return CCGEN_OK; CCGEN_ERROR_ARGUMENT for a null pointer or another window, which is not taken
 */
int ccgen_snapshot_set_window(ccgen_snapshot_t *snapshot, uint32_t window_us);

/**
 * Takes one frame.
 * \param[in] layout
 * \param[in,out] snapshot
 * \param[in] frame   any frame of the bus
 * \param[in] now_us  time of arrival
 * \return 1: a snapshot is complete, its counts stand in `counts`; 0: not yet, not ours, or dropped
 *         and counted; CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_snapshot_receive(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot,
                           const ccgen_frame_t *frame, uint32_t now_us);

/**
 * Notices silence: sets CCGEN_FAULT_STALE as long as it lasts.
 * \param[in] layout
 * \param[in,out] snapshot
 * \param[in] now_us
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_snapshot_tick(const ccgen_layout_t *layout, ccgen_snapshot_t *snapshot, uint32_t now_us);

/**
 * \param[in] snapshot
 * \param[in] now_us
 * \return milliseconds since the latest complete snapshot, at most CCGEN_AGE_MAX_MS, which also
 *         means "never"; CCGEN_AGE_MAX_MS for a null pointer
 */
uint8_t ccgen_snapshot_age_ms(const ccgen_snapshot_t *snapshot, uint32_t now_us);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_SNAPSHOT_H */
