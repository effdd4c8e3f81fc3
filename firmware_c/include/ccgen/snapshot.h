/**
 * \file snapshot.h
 * \brief Assembles the LENGTHS frames of one instant into a coherent snapshot of counts.
 *
 * All frames of a snapshot carry one counter. Counts come out only when every frame of one counter
 * has arrived, unharmed, within the window; old and new readings never mix. What is wrong with the
 * traffic is counted and flagged:
 *
 * - check value wrong -> corrupted; kind, length or counter impossible -> malformed; both ignored.
 * - The counter of the newest snapshot: a frame that is there already -> repeated; any frame once
 *   the snapshot is complete -> repeated; once it was late -> ignored.
 * - Ahead of the newest by less than half the modulus: a newer snapshot begins. One that was still
 *   incomplete is lost, and every counter skipped is one lost.
 * - Otherwise the frame is from the past -> reordered, ignored.
 * - A frame that arrives more than the window after its snapshot's first: the snapshot is late, and
 *   dropped whole.
 * - At the start, and after silence of more than three cycles (or the window, if that is longer),
 *   any counter begins a snapshot: a sender may restart. An incomplete one is then lost. Frames
 * from the past do not break the silence; repeated ones do.
 *
 * State belongs to the caller. Time is a free-running 32-bit count of microseconds; call
 * ccgen_snapshot_tick() at least every half hour. One frame takes time in proportion to its bytes
 * and, when it completes a snapshot, to the number of counts.
 */
#ifndef CCGEN_SNAPSHOT_H
#define CCGEN_SNAPSHOT_H

#include "ccgen/layout.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Fault flags of the status frame. They accumulate until a status frame has carried them. */
enum {
    CCGEN_FAULT_CRC = 0x01,
    CCGEN_FAULT_FORMAT = 0x02,
    CCGEN_FAULT_REPEATED = 0x04,
    CCGEN_FAULT_REORDERED = 0x08,
    CCGEN_FAULT_LOST = 0x10,    /**< an incomplete snapshot or a jump of the counter */
    CCGEN_FAULT_LATE = 0x20,    /**< a snapshot's frames spread over more than the window */
    CCGEN_FAULT_MISSING = 0x40, /**< a sensor's count was out of range */
    CCGEN_FAULT_STALE = 0x80    /**< no complete snapshot for more than three cycles */
};

/** An age in the status frame of this or more milliseconds, or no snapshot ever. */
#define CCGEN_AGE_MAX_MS 255u

/** What becomes of frames that carry the newest counter. */
typedef enum {
    CCGEN_SNAPSHOT_NONE,     /**< no counter is known: the next frame begins a snapshot */
    CCGEN_SNAPSHOT_PENDING,  /**< being assembled */
    CCGEN_SNAPSHOT_COMPLETE, /**< complete */
    CCGEN_SNAPSHOT_DROPPED   /**< was late */
} ccgen_snapshot_phase_t;

/** State, owned by the caller; the fields up to `counter` are for reading, the rest is internal. */
typedef struct {
    int32_t counts[CCGEN_COUNTS_MAX]; /**< latest complete snapshot: u sensors, then v sensors */
    uint32_t snapshots;               /**< complete ones */
    uint32_t corrupted;               /**< frames */
    uint32_t malformed;               /**< frames */
    uint32_t repeated;                /**< frames */
    uint32_t reordered;               /**< frames */
    uint32_t lost;                    /**< snapshots */
    uint32_t late;                    /**< snapshots */
    uint8_t counter;                  /**< of the latest complete snapshot */

    int32_t pending[CCGEN_COUNTS_MAX];
    uint32_t window_us;
    uint32_t first_us;
    uint32_t heard_us;
    uint32_t complete_us;
    uint16_t received;
    uint8_t newest;
    uint8_t faults;
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
 * \param[in] window_us  1 to CCGEN_PERIOD_MAX_US
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT
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
