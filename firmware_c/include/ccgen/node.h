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
 * A snapshot with a missing sensor has no estimate: its ANGLES and TIP frames go out with "no
 * reading" in every signal, and the status says which sensor. Call transmit until it returns 0
 * after every received frame: an estimate whose frames were not all fetched when the next one comes
 * is dropped and counted in `overruns`.
 *
 * A frame that was handed out counts as sent at the next call of transmit; until then
 * ccgen_node_unsent() takes it back. The faults that a STATUS frame carries are forgotten once it
 * counts as sent, and not before.
 *
 * State belongs to the caller, and one context at a time works on it: an interrupt that receives
 * frames hands them over (see queue.h). Times are those of snapshot.h. No heap, no globals, no
 * float (see tip.h for the conversion).
 */
#ifndef CCGEN_NODE_H
#define CCGEN_NODE_H

#include "ccgen/health.h"
#include "ccgen/layout.h"
#include "ccgen/snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What was handed out last and may still be taken back. */
typedef enum {
    CCGEN_HANDED_NOTHING,
    CCGEN_HANDED_ESTIMATE,
    CCGEN_HANDED_STATUS,
    CCGEN_HANDED_HEALTH
} ccgen_handed_t;

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
    uint16_t next;
    int16_t tip[3];
    uint8_t published;
    uint8_t status_counter;
    ccgen_handed_t handed;
    bool status_again; /* it was taken back */
    bool estimated;
} ccgen_node_t;

/**
 * Sets the state to: nothing received, nothing to send but a status.
 * \param[in] layout
 * \param[out] node
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or an invalid layout
 */
int ccgen_node_init(const ccgen_layout_t *layout, ccgen_node_t *node);

/** Takes one frame; parameters and result as ccgen_snapshot_receive(). */
int ccgen_node_receive(const ccgen_layout_t *layout, ccgen_node_t *node, const ccgen_frame_t *frame,
                       uint32_t now_us);

/**
 * Hands out counts of the latest complete snapshot, for a joint of precision 16.
 * \param[in] node
 * \param[in] first    the first sensor, in the joint's order
 * \param[in] sensors  how many; first + sensors at most CCGEN_SENSORS_MAX
 * \param[out] counts  [sensors]
 * \return CCGEN_OK, or CCGEN_ERROR_ARGUMENT for a null pointer or sensors that there are not
 */
int ccgen_node_counts16(const ccgen_node_t *node, uint8_t first, uint8_t sensors, int16_t *counts);

/** The same for a joint of precision 32; "no reading" is INT32_MIN whatever the count's width. */
int ccgen_node_counts32(const ccgen_node_t *node, uint8_t first, uint8_t sensors, int32_t *counts);

/**
 * Announces the outcome of the latest snapshot: its frames become due.
 * \param[in] layout
 * \param[in,out] node
 * \param[in] result   what NAME_estimate() returned; below 0: there are no angles
 * \param[in] missing  what NAME_missing() returned: mask of 16 bits
 * \param[in] tip      [3] tip position from ccgen_tip_signal(); read only when there are angles
 * \return 1: a new estimate stands; otherwise `result`; CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_node_publish(const ccgen_layout_t *layout, ccgen_node_t *node, int result,
                       int32_t missing, const int16_t *tip);

/**
 * Fetches the next frame to send, for a joint of precision 16.
 * \param[in] layout
 * \param[in,out] node
 * \param[in] angles  of u, v and h, [rows] each, of the snapshot last published; NULL for an axis
 *                    without rows
 * \param[in] now_us
 * \param[out] frame  to send; written only with result 1
 * \return 1: send `frame` and call again; 0: nothing is due; CCGEN_ERROR_ARGUMENT for a null
 * pointer
 */
int ccgen_node_transmit16(const ccgen_layout_t *layout, ccgen_node_t *node,
                          const int16_t *const angles[CCGEN_AXES_MAX], uint32_t now_us,
                          ccgen_frame_t *frame);

/** The same for a joint of precision 32. */
int ccgen_node_transmit32(const ccgen_layout_t *layout, ccgen_node_t *node,
                          const int32_t *const angles[CCGEN_AXES_MAX], uint32_t now_us,
                          ccgen_frame_t *frame);

/**
 * Takes back the frame that transmit handed out last, for it could not be sent: the next call of
 * transmit gives it again, a STATUS with all its faults.
 * \param[in,out] node
 * \return 1: it comes again; 0: there is none, or a newer snapshot has replaced its answer;
 *         CCGEN_ERROR_ARGUMENT for a null pointer
 */
int ccgen_node_unsent(ccgen_node_t *node);

#ifdef __cplusplus
}
#endif

#endif /* CCGEN_NODE_H */
