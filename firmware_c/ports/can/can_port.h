/**
 * \file can_port.h
 * \brief What the ports for CAN controllers have in common: settings, results, counters.
 *
 * A port CONTROLLER has four functions, and all its state is the caller's:
 *
 *     can_CONTROLLER_start()     bit timing, acceptance filters, then on the bus
 *     can_CONTROLLER_receive()   the interrupt: what came in goes to the queue `arrivals`
 *     can_CONTROLLER_transmit()  the main loop: hands a frame over, without waiting
 *     can_CONTROLLER_service()   the main loop, every millisecond: what was sent, what is too old,
 *                                bus-off, and frames that an interrupt missed
 *
 * So a node's loop is
 *
 *     can_CONTROLLER_service(&can, now_us);
 *     while (ccgen_queue_get(&can.arrivals, &frame, &at_us)) {
 *         (void)NAME_node_receive(&node, &frame, at_us);
 *     }
 *     while (NAME_node_transmit(&node, now_us, &frame) == 1) {
 *         if (can_CONTROLLER_transmit(&can, &frame, now_us) != 1) {
 *             (void)NAME_node_unsent(&node);    // no room: it comes again
 *             break;
 *         }
 *     }
 *
 * Frames leave in the order in which they were handed over. One that has waited for longer than
 * `cycle_us` is aborted: a newer one tells more. Nothing waits for a node that acknowledges.
 */
#ifndef CAN_PORT_H
#define CAN_PORT_H

#include "ccgen/frame.h"
#include "ccgen/queue.h"

/** What functions return beside 1, done, and 0, not now. */
enum {
    CAN_PORT_OK = 0,
    CAN_PORT_ERROR_TIMING = -1,  /**< the clock does not give the bit rate */
    CAN_PORT_ERROR_FILTERS = -2, /**< the controller has fewer filters */
    CAN_PORT_ERROR_SILENT = -3,  /**< the controller does not answer: no clock, no driver */
    CAN_PORT_ERROR_FRAME = -4    /**< a frame that the controller can never send */
};

/** Lets in identifiers that agree with `id` where `mask` has ones. */
typedef struct {
    uint32_t id;
    uint32_t mask;
} can_port_filter_t;

/** Settings; need not outlive start(). */
typedef struct {
    uint32_t clock_hz; /**< of the controller */
    uint32_t bitrate;
    uint32_t data_bitrate;            /**< of CAN FD with bit-rate switch; else 0 */
    uint32_t cycle_us;                /**< a frame that has waited for longer is aborted */
    const can_port_filter_t *filters; /**< none: nothing comes in */
    uint8_t filter_count;
    bool extended; /**< the filters' identifiers have 29 bits */
    bool fd;
} can_port_config_t;

/** What happened since start(), modulo 2^32. The interrupt counts the first two. */
typedef struct {
    volatile uint32_t received; /**< frames put into the queue */
    volatile uint32_t dropped;  /**< frames that found the queue full, and overruns of the
                                     controller, of which each lost at least one */
    uint32_t sent;              /**< frames that another node acknowledged */
    uint32_t aborted;           /**< frames given up: too old, or pending at bus-off */
    uint32_t bus_off;           /**< times that the controller left the bus */
    uint32_t errors;            /**< calls of service() that found new errors of the bus */
} can_port_counters_t;

/** Queues a frame that came in, and counts it; for the interrupt. */
static inline void can_port_arrived(volatile can_port_counters_t *const counters,
                                    ccgen_queue_t *const arrivals,
                                    const ccgen_frame_t *const frame, const uint32_t now_us) {
    if (ccgen_queue_put(arrivals, frame, now_us)) {
        counters->received = counters->received + 1u;
    } else {
        counters->dropped = counters->dropped + 1u;
    }
}

/** How registers are accessed; tests put a model of the controller in their place. */
#if !defined(CAN_PORT_READ)
#define CAN_PORT_READ(address) (*(address))
#define CAN_PORT_WRITE(address, value) (*(address) = (value))
#endif

#endif /* CAN_PORT_H */
