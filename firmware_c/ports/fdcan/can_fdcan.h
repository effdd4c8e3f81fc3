/**
 * \file can_fdcan.h
 * \brief CAN and CAN FD on STM32 whose FDCAN has a message RAM of fixed layout: G4, and G0, L5, U5,
 * H5, C0, which have the same. Not H7, whose message RAM is divided by software.
 *
 * On registers alone, as the reference manual gives them (RM0440, chapter FDCAN), without ST's
 * library. It has never run on its controller: it has run against a model of the registers.
 *
 * Before start() the application clocks the controller and its pins, and lets the interrupt of
 * line 0 through:
 *
 *     void FDCAN1_IT0_IRQHandler(void) {
 *         can_fdcan_receive(&can, time_us());
 *     }
 *
 * The priority of that interrupt is free. Without it, service() alone receives, and has to be
 * called before the FIFO overruns: every three frames that the filters let in.
 *
 * - Filters: 28 of standard identifiers or 8 of extended ones; what passes none is rejected.
 * - FIFO 0 holds three frames; one that finds it full is discarded, and counted in `dropped`.
 * - Three transmit buffers work as a FIFO.
 * - CAN FD: the delay of the transceiver is compensated where the data phase has a prescaler of 1
 *   or 2, which the controller asks for. Other timings are refused unless their data phase samples
 *   later than transceivers delay (255 ns, ISO 11898-2).
 * - At bus-off what is pending is aborted, and service() has the controller wait for 129 times 11
 *   recessive bits and join the bus again.
 *
 * receive() and service() read the same FIFO: where the interrupt meets service() there, it is held
 * back by its own enable bit until service() has read all.
 */
#ifndef CAN_FDCAN_H
#define CAN_FDCAN_H

#include "can_port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define CAN_FDCAN_BUFFERS 3

/** State, owned by the caller; `counters` and `arrivals` are its to use. */
typedef struct {
    can_port_counters_t counters;
    ccgen_queue_t arrivals;
    volatile uint32_t *registers;
    volatile uint32_t *memory;
    uint32_t cycle_us;
    uint32_t handed_us[CAN_FDCAN_BUFFERS];
    uint32_t pending;      /* a bit a buffer */
    bool fd;
    bool off;              /* left the bus, and not yet back */
    volatile bool reading; /* service() is reading the FIFO */
} can_fdcan_t;

/**
 * Sets the controller up and lets it join the bus.
 * \param[out] can
 * \param[in] registers  FDCAN1 of G4: 0x40006400
 * \param[in] memory  its part of the message RAM; FDCAN1 of G4: 0x4000A400
 * \param[in] config  `clock_hz` is that of the controller's kernel, fdcan_tq_ck
 * \return CAN_PORT_OK; CAN_PORT_ERROR_TIMING, _FILTERS, _SILENT
 */
int can_fdcan_start(can_fdcan_t *can, volatile uint32_t *registers, volatile uint32_t *memory,
                    const can_port_config_t *config);

/**
 * Reads all that came in; for the interrupt.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_fdcan_receive(can_fdcan_t *can, uint32_t now_us);

/**
 * Hands a frame over; never waits.
 * \param[in,out] can
 * \param[in] frame
 * \param[in] now_us
 * \return 1: it leaves; 0: no room, or off the bus; CAN_PORT_ERROR_FRAME: CAN FD without `fd`, or a
 *         length that no frame has
 */
int can_fdcan_transmit(can_fdcan_t *can, const ccgen_frame_t *frame, uint32_t now_us);

/**
 * Counts what was sent, aborts what is too old, comes back from bus-off, and reads what an
 * interrupt may have missed; every millisecond.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_fdcan_service(can_fdcan_t *can, uint32_t now_us);

#ifdef __cplusplus
}
#endif

#endif /* CAN_FDCAN_H */
