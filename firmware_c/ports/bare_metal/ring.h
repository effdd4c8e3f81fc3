/**
 * \file ring.h
 * \brief A queue of bytes from one interrupt to the main loop, without locks.
 *
 * The interrupt alone moves `head`, the main loop alone moves `tail`. Both are single bytes, which
 * every core reads and writes in one go, and they wrap by themselves. One place stays empty, so
 * that full and empty differ.
 */
#ifndef RING_H
#define RING_H

#include <stdbool.h>
#include <stdint.h>

#define RING_PLACES 256u

typedef struct {
    volatile uint8_t head; /**< where the next byte goes */
    volatile uint8_t tail; /**< where the oldest byte is */
    volatile uint8_t bytes[RING_PLACES];
} ring_t;

/** \return how many bytes wait */
static inline uint8_t ring_used(const ring_t *const ring) {
    return (uint8_t)(ring->head - ring->tail);
}

/** \return whether no byte fits any more */
static inline bool ring_full(const ring_t *const ring) {
    return ring_used(ring) == (RING_PLACES - 1u);
}

/** Appends a byte to a ring that is not full. */
static inline void ring_put(ring_t *const ring, const uint8_t byte) {
    ring->bytes[ring->head] = byte;
    ring->head = (uint8_t)(ring->head + 1u);
}

/** \return the oldest byte, taken off the ring; -1 if it is empty */
static inline int ring_get(ring_t *const ring) {
    if (ring->head == ring->tail) {
        return -1;
    }
    const uint8_t byte = ring->bytes[ring->tail];
    ring->tail = (uint8_t)(ring->tail + 1u);
    return byte;
}

#endif /* RING_H */
