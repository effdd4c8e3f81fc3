/**
 * \file can_mcp2515.h
 * \brief Classic CAN through Microchip's MCP2515, on an SPI bus.
 *
 *     void int_pin_interrupt(void) {                   // falling edge of INT
 *         can_mcp2515_receive(&can, time_us());
 *     }
 *
 *     if (can_mcp2515_start(&can, &board, &config) == CAN_PORT_OK) {
 *         for (;;) {
 *             can_mcp2515_service(&can, time_us());
 *             ...                                      // queue and node, as in can_port.h
 *         }
 *     }
 *
 * One interrupt and one main loop, on one core, share the chip: the interrupt calls receive()
 * alone, the main loop all others. Whoever comes while the other speaks with the chip leaves his
 * work to him: nothing waits, and interrupts stay on. So INT has to be an edge to the processor,
 * and whatever else is on the SPI bus is spoken to between hold() and release(). An edge that was
 * lost is made good by the next service(), which looks at the level. Without the interrupt,
 * service() has to come round in less than two frames' time.
 *
 * - Filters: six, of which the first two have one mask and the other four another.
 * - The FIFO holds two frames, of the first two filters, which go on to the second buffer where
 *   the first is full; one of the other four. A frame that finds it full is discarded, and counted
 *   in `dropped`.
 * - Frames leave in the order in which they were given, through one transmit buffer; up to
 *   CAN_MCP2515_DEPARTURES wait before it.
 * - At bus-off what is pending is aborted, and nothing is taken until the chip has recovered, which
 *   it does by itself after 128 times 11 recessive bits.
 * - A chip that has lost its settings, because its supply broke down, is set up anew.
 *
 * It has never run on its controller: it has run on an emulated AVR against a model of the chip,
 * which follows Microchip's data sheet DS20001801.
 */
#ifndef CAN_MCP2515_H
#define CAN_MCP2515_H

#include "can_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Frames that wait for the bus: a power of two up to 128. Those that came in: see queue.h. */
#if !defined(CAN_MCP2515_DEPARTURES)
#define CAN_MCP2515_DEPARTURES 8
#endif

#define CAN_MCP2515_FILTERS 6
/** Most bytes of one exchange. */
#define CAN_MCP2515_EXCHANGE_MAX 14

/** What the board gives; lives as long as the port. */
typedef struct {
    void *context; /**< handed to the functions */
    /**
     * Selects the chip, exchanges `number` bytes in their place, and deselects it: SPI mode 0, most
     * significant bit first, 10 MHz at most.
     */
    void (*exchange)(void *context, uint8_t *bytes, uint8_t number);
    /** Tells whether INT is low; NULL: the chip is asked over SPI instead. */
    bool (*waits)(void *context);
} can_mcp2515_board_t;

/** A frame as the chip's buffers hold it, and when it was given. */
typedef struct {
    uint32_t at_us;
    uint8_t bytes[13];
} can_mcp2515_place_t;

/**
 * State, owned by the caller; `arrivals` is its to use. What both contexts touch is volatile, and
 * but for the queues' ends it is touched while `busy` alone.
 */
typedef struct {
    volatile can_port_counters_t counters; /**< can_mcp2515_counters() reads them */
    ccgen_queue_t arrivals;
    const can_mcp2515_board_t *volatile board;
    uint32_t cycle_us;
    uint8_t settings[36];   /**< registers RXF0 to RXF2, RXF3 to RXF5, RXM0 to CANINTE */
    volatile bool busy;     /**< somebody speaks with the chip */
    volatile bool missed;   /**< somebody else wanted to, meanwhile */
    volatile bool running;  /**< the chip has its settings */
    volatile bool off;      /**< left the bus, and not yet back */
    volatile bool loaded;   /**< a frame is in the transmit buffer */
    volatile bool aborting; /**< and is to leave it unsent */
    volatile uint32_t handed_us;
    volatile uint32_t looked_us;
    volatile uint8_t head, tail; /**< of `departures` */
    volatile can_mcp2515_place_t departures[CAN_MCP2515_DEPARTURES];
} can_mcp2515_t;

/**
 * Resets the chip, sets it up and lets it join the bus. The interrupt may be on before that, where
 * the state is zero: it does nothing then.
 * \param[out] can
 * \param[in] board
 * \param[in] config  `clock_hz` is that of the chip's crystal, 40 MHz at most; six filters
 * \return CAN_PORT_OK; CAN_PORT_ERROR_FRAME: CAN FD; CAN_PORT_ERROR_TIMING: the crystal does not
 *         give exactly that bit rate; CAN_PORT_ERROR_FILTERS: not six, or more than two masks;
 *         CAN_PORT_ERROR_SILENT: nothing answers as an MCP2515
 */
int can_mcp2515_start(can_mcp2515_t *can, const can_mcp2515_board_t *board,
                      const can_port_config_t *config);

/**
 * Fetches what came in, and loads the next frame where one has left; for the interrupt.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_mcp2515_receive(can_mcp2515_t *can, uint32_t now_us);

/**
 * Gives a frame to be sent behind those before it; never waits.
 * \param[in,out] can
 * \param[in] frame
 * \param[in] now_us
 * \return 1: it leaves; 0: no room, off the bus, or no chip; CAN_PORT_ERROR_FRAME: CAN FD, or too
 *         long
 */
int can_mcp2515_transmit(can_mcp2515_t *can, const ccgen_frame_t *frame, uint32_t now_us);

/**
 * Does what receive() does where INT is low, aborts what is too old and looks after errors: every
 * round of the main loop.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_mcp2515_service(can_mcp2515_t *can, uint32_t now_us);

/**
 * Reads the counters, all at one time.
 * \param[in,out] can
 * \param[out] counters
 */
void can_mcp2515_counters(can_mcp2515_t *can, can_port_counters_t *counters);

/**
 * Keeps the interrupt off the SPI bus, for the main loop to speak with another chip.
 * \param[in,out] can
 */
void can_mcp2515_hold(can_mcp2515_t *can);

/**
 * Ends can_mcp2515_hold(), and makes good what was missed.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_mcp2515_release(can_mcp2515_t *can, uint32_t now_us);

#ifdef __cplusplus
}
#endif

#endif /* CAN_MCP2515_H */
