/**
 * \file can_bxcan.h
 * \brief Classic CAN on STM32 with bxCAN: F0, F1, F2, F3, F4, F7, L1, L4.
 *
 * On registers alone, as the reference manuals give them (RM0008, RM0090: chapter bxCAN), without
 * ST's library. It has never run on its controller: it has run against a model of the registers.
 *
 * Before start() the application clocks the controller and its pins, and lets the receive
 * interrupt through:
 *
 *     void CAN1_RX0_IRQHandler(void) {
 *         can_bxcan_receive(&can, time_us());
 *     }
 *
 * The priority of that interrupt is free. Without it, service() alone receives, and has to be
 * called before the FIFO overruns: every three frames that the filters let in.
 *
 * - Filters: one bank of 32 bits each, 14 at most, those of CAN1.
 * - FIFO 0 holds three frames; one that finds it full is discarded, and counted in `dropped`.
 * - Three mailboxes leave in the order in which they were filled (TXFP).
 * - At bus-off what is pending is aborted; service() has the controller wait for 128 times 11
 *   recessive bits and join the bus again.
 *
 * receive() and service() read the same FIFO: where the interrupt meets service() there, it is held
 * back by its own enable bit until service() has read all.
 */
#ifndef CAN_BXCAN_H
#define CAN_BXCAN_H

#include "can_port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define CAN_BXCAN_MAILBOXES 3
#define CAN_BXCAN_FILTERS 14

/** State, owned by the caller; `counters` and `arrivals` are its to use. */
typedef struct {
    can_port_counters_t counters;
    ccgen_queue_t arrivals;
    volatile uint32_t *registers;
    uint32_t cycle_us;
    uint32_t handed_us[CAN_BXCAN_MAILBOXES];
    bool pending[CAN_BXCAN_MAILBOXES];
    bool off;              /* left the bus, and not yet back */
    volatile bool reading; /* service() is reading the FIFO */
} can_bxcan_t;

/**
 * Sets the controller up and lets it join the bus.
 * \param[out] can
 * \param[in] registers  CAN1, 0x40006400
 * \param[in] config  `clock_hz` is that of APB1
 * \return CAN_PORT_OK; CAN_PORT_ERROR_FRAME: CAN FD; CAN_PORT_ERROR_TIMING, _FILTERS, _SILENT
 */
int can_bxcan_start(can_bxcan_t *can, volatile uint32_t *registers, const can_port_config_t *config);

/**
 * Reads all that came in; for the interrupt.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_bxcan_receive(can_bxcan_t *can, uint32_t now_us);

/**
 * Hands a frame over; never waits.
 * \param[in,out] can
 * \param[in] frame
 * \param[in] now_us
 * \return 1: it leaves; 0: no room, or off the bus; CAN_PORT_ERROR_FRAME: CAN FD, or too long
 */
int can_bxcan_transmit(can_bxcan_t *can, const ccgen_frame_t *frame, uint32_t now_us);

/**
 * Counts what was sent, aborts what is too old, comes back from bus-off, and reads what an
 * interrupt may have missed; every millisecond.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_bxcan_service(can_bxcan_t *can, uint32_t now_us);

#ifdef __cplusplus
}
#endif

#endif /* CAN_BXCAN_H */
