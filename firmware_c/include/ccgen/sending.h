/**
 * \file sending.h
 * \brief The other side of a node: LENGTHS frames of a board that measures (sending_inline.h).
 *
 * The generated NAME_can.c wraps this for one joint. ccgen_sending_begin() begins a sending when one
 * is due; its counts are put into `counts`, and its frames go out one a call of ccgen_sending_transmit(), all
 * under one number. What the bus owes a node (see snapshot.h) is kept here:
 *
 * - Every sending takes the number behind that of the last.
 * - There is one a cycle at most, on average: a call less than half a cycle early is early and
 *   counts on, one that is earlier begins nothing.
 * - A start is silent: nothing begins until a window has passed since the first call, unless
 *   ccgen_sending_resume() says which number was the last.
 *
 * State belongs to the caller; one context at a time works on it. Time is a free-running 32-bit
 * count of microseconds that wraps; begin is called at least every 30 minutes.
 */
#ifndef CCGEN_SENDING_H
#define CCGEN_SENDING_H

#include "ccgen/layout.h"

/** State, owned by the caller; the fields up to `number` are for reading, the rest is internal. */
typedef struct {
    uint32_t sendings; /**< that were begun */
    uint32_t overruns; /**< replaced before all their frames were fetched */
    uint8_t number;    /**< of the latest; keep it over a restart for ccgen_sending_resume() */

    int32_t counts[CCGEN_SENSORS_MAX]; /* of the latest, by ccgen_put_counts16() or 32 */
    uint32_t window_us;
    uint32_t window_max_us;
    uint32_t now_us;   /* the latest time that was told */
    uint32_t begun_us; /* of the latest sending, or of the silence */
    uint32_t ahead_us; /* of the cycles, at most half a one */
    uint8_t next;      /* LENGTHS frame to fetch */
    bool handed;
    bool started;
    bool silent;
} ccgen_sending_t;

#endif /* CCGEN_SENDING_H */
