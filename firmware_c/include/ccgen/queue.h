/**
 * \file queue.h
 * \brief Frames and their times of arrival, from one interrupt to the main loop, without locks.
 *
 * Receive and transmit of a node belong to one context. Where an interrupt reads the controller, it
 * puts what it reads into this queue, and the main loop takes it out and hands it to the node:
 *
 *     static ccgen_queue_t arrivals;               // zero: empty
 *
 *     void can_interrupt(void) {
 *         ccgen_frame_t frame;
 *         while (can_read(&frame)) {
 *             (void)ccgen_queue_put(&arrivals, &frame, time_us());
 *         }
 *     }
 *
 *     uint32_t at_us;                              // in the main loop
 *     while (ccgen_queue_get(&arrivals, &frame, &at_us)) {
 *         (void)NAME_node_receive(&node, &frame, at_us);
 *     }
 *
 * One interrupt alone puts, one context alone gets, both on one core; several interrupts need a
 * queue each. The frame that transmit was last called before may be younger than the stamps that
 * wait here: times may come out of order (see snapshot.h).
 */
#ifndef CCGEN_QUEUE_H
#define CCGEN_QUEUE_H

#include "ccgen/frame.h"

/** Frames that fit: a power of two up to 128. A snapshot has 1 to 16. */
#if !defined(CCGEN_QUEUE_PLACES)
#define CCGEN_QUEUE_PLACES 16u
#endif

CCGEN_STATIC_ASSERT((CCGEN_QUEUE_PLACES >= 1) && (CCGEN_QUEUE_PLACES <= 128) &&
                        ((CCGEN_QUEUE_PLACES & (CCGEN_QUEUE_PLACES - 1)) == 0),
                    queue_places_are_a_power_of_two);

/**
 * State, owned by the caller. The interrupt alone moves `head`, the main loop alone moves `tail`;
 * both are single bytes, which every core reads and writes in one go, and wrap by themselves. All
 * is volatile, so that a frame is in its place before `head` says so.
 */
typedef struct {
    volatile uint8_t head; /**< frames put so far, modulo 256 */
    volatile uint8_t tail; /**< frames taken so far, modulo 256 */
    volatile uint32_t at_us[CCGEN_QUEUE_PLACES];
    volatile ccgen_frame_t frames[CCGEN_QUEUE_PLACES];
} ccgen_queue_t;

/**
 * Appends a frame; for the interrupt.
 * \param[in,out] queue
 * \param[in] frame
 * \param[in] now_us  time of its arrival
 * \return false: the queue is full and the frame is lost, which the node will notice
 */
static inline bool ccgen_queue_put(ccgen_queue_t *const queue, const ccgen_frame_t *const frame,
                                   const uint32_t now_us) {
    const uint8_t head = queue->head;
    const uint8_t place = CCGEN_CAST(uint8_t, head % CCGEN_QUEUE_PLACES);
    volatile ccgen_frame_t *const to = &queue->frames[place];
    if ((CCGEN_CAST(uint8_t, head - queue->tail) == CCGEN_QUEUE_PLACES) ||
        (frame->length > CCGEN_FRAME_CAPACITY)) {
        return false;
    }
    queue->at_us[place] = now_us;
    to->id = frame->id;
    to->extended = frame->extended;
    to->fd = frame->fd;
    to->remote = frame->remote;
    to->rate_switch = frame->rate_switch;
    to->length = frame->length;
    for (uint8_t i = 0; i < frame->length; ++i) {
        to->data[i] = frame->data[i];
    }
    queue->head = CCGEN_CAST(uint8_t, head + 1u);
    return true;
}

/**
 * Takes the oldest frame; for the main loop.
 * \param[in,out] queue
 * \param[out] frame   data beyond its length stays as it is
 * \param[out] now_us  time of its arrival
 * \return false: the queue is empty, nothing is written
 */
static inline bool ccgen_queue_get(ccgen_queue_t *const queue, ccgen_frame_t *const frame,
                                   uint32_t *const now_us) {
    const uint8_t tail = queue->tail;
    const uint8_t place = CCGEN_CAST(uint8_t, tail % CCGEN_QUEUE_PLACES);
    const volatile ccgen_frame_t *const from = &queue->frames[place];
    if (queue->head == tail) {
        return false;
    }
    *now_us = queue->at_us[place];
    frame->id = from->id;
    frame->extended = from->extended;
    frame->fd = from->fd;
    frame->remote = from->remote;
    frame->rate_switch = from->rate_switch;
    frame->length = from->length;
    for (uint8_t i = 0; i < frame->length; ++i) {
        frame->data[i] = from->data[i];
    }
    queue->tail = CCGEN_CAST(uint8_t, tail + 1u);
    return true;
}

#endif /* CCGEN_QUEUE_H */
