/**
 * \file can_twai.h
 * \brief Classic CAN on ESP32 with ESP-IDF's TWAI drivers: the node API of 5.5 and later, the driver
 * of 5.1 to 5.4 before that.
 *
 * It has never run on its controller: it has run against a model of both drivers' documented
 * interfaces.
 *
 * All functions are called by one task, that of start(). With the node API the driver's interrupt
 * reads frames into `arrivals`; before, service() fetches them from the driver's queue.
 *
 * - Filters: the controller has one; it lets in what agrees with all given ones, and may let in
 *   others beside. A node ignores those.
 * - FIFO: 64 bytes, about five frames. The node API does not tell of its overruns.
 * - One frame at a time is the driver's, whose buffer it keeps live here; sent once, and again by
 *   service() until it is older than a cycle. So nothing old is left in the controller.
 * - At bus-off what is in flight is aborted; service() starts the recovery.
 * - A bit rate that the clock does not give exactly: the node API rounds it, and logs that.
 */
#ifndef CAN_TWAI_H
#define CAN_TWAI_H

#include "can_port.h"
#include "esp_idf_version.h"
#include "freertos/FreeRTOS.h"
#include "freertos/task.h"

#if ESP_IDF_VERSION >= ESP_IDF_VERSION_VAL(5, 5, 0)
#define CAN_TWAI_NODE 1
#include "esp_twai.h"
#include "esp_twai_onchip.h"
#else
#define CAN_TWAI_NODE 0
#include "driver/twai.h"
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Where the frame is that was handed over last. */
typedef enum { CAN_TWAI_NONE, CAN_TWAI_FLYING, CAN_TWAI_SENT, CAN_TWAI_FAILED } can_twai_flight_t;

/** State, owned by the caller; `counters` and `arrivals` are its to use. */
typedef struct {
    can_port_counters_t counters;
    ccgen_queue_t arrivals;
    TaskHandle_t task;
    uint32_t cycle_us;
    uint32_t handed_us;
    volatile can_twai_flight_t flight;
    volatile bool erred; /* an error of the bus since */
    bool off;            /* left the bus, and not yet back */
#if CAN_TWAI_NODE
    twai_node_handle_t node;
    twai_frame_t outgoing; /* the driver's while it flies, and its data */
    uint8_t data[8];
#else
    twai_message_t outgoing;
    uint32_t alerts;  /* that rest() has read */
    uint32_t overran; /* frames that the driver has lost so far */
#endif
} can_twai_t;

/**
 * Installs the driver and joins the bus.
 * \param[out] can
 * \param[in] transmit_pin  GPIO
 * \param[in] receive_pin  GPIO
 * \param[in] config  `clock_hz` is not used: the driver knows it
 * \return CAN_PORT_OK; CAN_PORT_ERROR_FRAME: CAN FD; CAN_PORT_ERROR_TIMING: the driver refuses the
 *         bit rate; CAN_PORT_ERROR_SILENT: no driver, no controller, no memory
 */
int can_twai_start(can_twai_t *can, int transmit_pin, int receive_pin,
                   const can_port_config_t *config);

/**
 * Hands a frame over; never waits.
 * \param[in,out] can
 * \param[in] frame
 * \param[in] now_us
 * \return 1: it leaves; 0: no room, or off the bus; CAN_PORT_ERROR_FRAME: CAN FD, or too long
 */
int can_twai_transmit(can_twai_t *can, const ccgen_frame_t *frame, uint32_t now_us);

/**
 * Counts what was sent, sends again what was not, aborts what is too old, recovers from bus-off;
 * every millisecond.
 * \param[in,out] can
 * \param[in] now_us
 */
void can_twai_service(can_twai_t *can, uint32_t now_us);

/**
 * Sleeps until a frame came or left, a tick at most.
 * \param[in,out] can
 */
void can_twai_rest(can_twai_t *can);

#ifdef __cplusplus
}
#endif

#endif /* CAN_TWAI_H */
