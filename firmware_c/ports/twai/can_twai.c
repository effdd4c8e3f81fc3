/**
 * \file can_twai.c
 * \brief See can_twai.h.
 */
#include "can_twai.h"

#include <string.h>

#include "esp_timer.h"

/** One filter that lets in what any of some lets in; none: all zeros alone. */
static can_port_filter_t common_filter(const can_port_config_t *const config) {
    can_port_filter_t all = {0u, config->extended ? 0x1FFFFFFFu : 0x7FFu};
    if (config->filter_count > 0u) {
        all = config->filters[0];
    }
    for (uint8_t i = 1; i < config->filter_count; ++i) {
        all.mask &= config->filters[i].mask & ~(all.id ^ config->filters[i].id);
    }
    all.id &= all.mask;
    return all;
}

#if CAN_TWAI_NODE

static bool wake(const can_twai_t *const can) {
    BaseType_t woken = pdFALSE;
    vTaskNotifyGiveFromISR(can->task, &woken);
    return woken == pdTRUE;
}

static bool arrived(twai_node_handle_t node, const twai_rx_done_event_data_t *event,
                    void *const context) {
    can_twai_t *const can = (can_twai_t *)context;
    ccgen_frame_t frame = CCGEN_ZERO;
    twai_frame_t in;
    (void)event;
    memset(&in, 0, sizeof in);
    in.buffer = frame.data;
    in.buffer_len = 8u;
    if (twai_node_receive_from_isr(node, &in) == ESP_OK) {
        frame.id = in.header.id;
        frame.extended = in.header.ide != 0u;
        frame.remote = in.header.rtr != 0u;
        frame.length = (uint8_t)((in.header.dlc > 8u) ? 8u : in.header.dlc);
        can_port_arrived(&can->counters, &can->arrivals, &frame,
                         (uint32_t)esp_timer_get_time());
    }
    return wake(can);
}

static bool departed(twai_node_handle_t node, const twai_tx_done_event_data_t *const event,
                     void *const context) {
    can_twai_t *const can = (can_twai_t *)context;
    (void)node;
    can->flight = event->is_tx_success ? CAN_TWAI_SENT : CAN_TWAI_FAILED;
    return wake(can);
}

static bool erred(twai_node_handle_t node, const twai_error_event_data_t *event,
                  void *const context) {
    (void)node;
    (void)event;
    ((can_twai_t *)context)->erred = true;
    return false;
}

static int install(can_twai_t *const can, const int transmit_pin, const int receive_pin,
                   const can_port_config_t *const config) {
    const can_port_filter_t filter = common_filter(config);
    twai_onchip_node_config_t settings;
    twai_mask_filter_config_t mask;
    twai_event_callbacks_t callbacks;
    memset(&settings, 0, sizeof settings);
    memset(&mask, 0, sizeof mask);
    memset(&callbacks, 0, sizeof callbacks);
    settings.io_cfg.tx = (gpio_num_t)transmit_pin;
    settings.io_cfg.rx = (gpio_num_t)receive_pin;
    settings.io_cfg.quanta_clk_out = (gpio_num_t)-1;
    settings.io_cfg.bus_off_indicator = (gpio_num_t)-1;
    settings.bit_timing.bitrate = config->bitrate;
    settings.fail_retry_cnt = 0; /* service() repeats */
    settings.tx_queue_depth = 1u;
    mask.id = filter.id;
    mask.mask = filter.mask;
    mask.is_ext = config->extended ? 1u : 0u;
    callbacks.on_rx_done = arrived;
    callbacks.on_tx_done = departed;
    callbacks.on_error = erred;
    const esp_err_t made = twai_new_node_onchip(&settings, &can->node);
    if (made != ESP_OK) {
        return (made == ESP_ERR_INVALID_ARG) ? CAN_PORT_ERROR_TIMING : CAN_PORT_ERROR_SILENT;
    }
    if ((twai_node_config_mask_filter(can->node, 0, &mask) != ESP_OK) ||
        (twai_node_register_event_callbacks(can->node, &callbacks, can) != ESP_OK) ||
        (twai_node_enable(can->node) != ESP_OK)) {
        (void)twai_node_delete(can->node);
        return CAN_PORT_ERROR_SILENT;
    }
    return CAN_PORT_OK;
}

static void prepare(can_twai_t *const can, const ccgen_frame_t *const frame) {
    memset(&can->outgoing, 0, sizeof can->outgoing);
    memcpy(can->data, frame->data, frame->length);
    can->outgoing.header.id = frame->id;
    can->outgoing.header.ide = frame->extended ? 1u : 0u;
    can->outgoing.header.rtr = frame->remote ? 1u : 0u;
    can->outgoing.header.dlc = frame->length;
    can->outgoing.buffer = can->data;
    can->outgoing.buffer_len = frame->length;
}

static bool launch(can_twai_t *const can) {
    can->flight = CAN_TWAI_FLYING; /* before the driver may call back */
    if (twai_node_transmit(can->node, &can->outgoing, 0) != ESP_OK) {
        can->flight = CAN_TWAI_NONE;
        return false;
    }
    return true;
}

/** Nothing to fetch: the interrupt has done it. */
static void fetch(const can_twai_t *const can, const uint32_t now_us) {
    (void)can;
    (void)now_us;
}

static bool is_off(const can_twai_t *const can) {
    twai_node_status_t status;
    return (twai_node_get_info(can->node, &status, NULL) == ESP_OK) &&
           (status.state == TWAI_ERROR_BUS_OFF);
}

static void recover(const can_twai_t *const can) {
    (void)twai_node_recover(can->node);
}

void can_twai_rest(can_twai_t *const can) {
    (void)can;
    (void)ulTaskNotifyTake(pdTRUE, 1);
}

#else

#define ALERTS                                                                                 \
    (TWAI_ALERT_RX_DATA | TWAI_ALERT_TX_SUCCESS | TWAI_ALERT_TX_FAILED | TWAI_ALERT_BUS_ERROR | \
     TWAI_ALERT_BUS_OFF | TWAI_ALERT_BUS_RECOVERED)
#define QUANTA 20u

static int install(can_twai_t *const can, const int transmit_pin, const int receive_pin,
                   const can_port_config_t *const config) {
    const can_port_filter_t filter = common_filter(config);
    const uint32_t shift = config->extended ? 3u : 21u;
    twai_general_config_t general;
    twai_timing_config_t timing;
    twai_filter_config_t acceptance;
    (void)can;
    memset(&general, 0, sizeof general);
    memset(&timing, 0, sizeof timing);
    memset(&acceptance, 0, sizeof acceptance);
    general.mode = TWAI_MODE_NORMAL;
    general.tx_io = (gpio_num_t)transmit_pin;
    general.rx_io = (gpio_num_t)receive_pin;
    general.clkout_io = TWAI_IO_UNUSED;
    general.bus_off_io = TWAI_IO_UNUSED;
    general.rx_queue_len = CCGEN_QUEUE_PLACES;
    general.alerts_enabled = ALERTS;
    timing.quanta_resolution_hz = config->bitrate * QUANTA;
    timing.tseg_1 = 15;
    timing.tseg_2 = 4;
    timing.sjw = 3;
    acceptance.acceptance_code = filter.id << shift;
    acceptance.acceptance_mask = ~(filter.mask << shift); /* ones: any bit */
    acceptance.single_filter = true;
    const esp_err_t made = twai_driver_install(&general, &timing, &acceptance);
    if (made != ESP_OK) {
        return (made == ESP_ERR_INVALID_ARG) ? CAN_PORT_ERROR_TIMING : CAN_PORT_ERROR_SILENT;
    }
    if (twai_start() != ESP_OK) {
        (void)twai_driver_uninstall();
        return CAN_PORT_ERROR_SILENT;
    }
    return CAN_PORT_OK;
}

static void prepare(can_twai_t *const can, const ccgen_frame_t *const frame) {
    memset(&can->outgoing, 0, sizeof can->outgoing);
    can->outgoing.identifier = frame->id;
    can->outgoing.extd = frame->extended ? 1u : 0u;
    can->outgoing.rtr = frame->remote ? 1u : 0u;
    can->outgoing.ss = 1u; /* service() repeats */
    can->outgoing.data_length_code = frame->length;
    memcpy(can->outgoing.data, frame->data, frame->length);
}

static bool launch(can_twai_t *const can) {
    const bool taken = twai_transmit(&can->outgoing, 0) == ESP_OK;
    can->flight = taken ? CAN_TWAI_FLYING : CAN_TWAI_NONE;
    return taken;
}

/** Fetches what the driver's queue holds and what it tells. */
static void fetch(can_twai_t *const can, const uint32_t now_us) {
    twai_message_t in;
    twai_status_info_t status;
    uint32_t alerts = 0;
    for (uint32_t i = 0; (i < CCGEN_QUEUE_PLACES) && (twai_receive(&in, 0) == ESP_OK); ++i) {
        ccgen_frame_t frame = CCGEN_ZERO;
        frame.id = in.identifier;
        frame.extended = in.extd != 0u;
        frame.remote = in.rtr != 0u;
        frame.length = (uint8_t)((in.data_length_code > 8u) ? 8u : in.data_length_code);
        memcpy(frame.data, in.data, frame.length);
        can_port_arrived(&can->counters, &can->arrivals, &frame, now_us);
    }
    (void)twai_read_alerts(&alerts, 0);
    alerts |= can->alerts;
    can->alerts = 0;
    can->erred = (alerts & TWAI_ALERT_BUS_ERROR) != 0u;
    if (can->flight == CAN_TWAI_FLYING) {
        if ((alerts & TWAI_ALERT_TX_FAILED) != 0u) {
            can->flight = CAN_TWAI_FAILED;
        } else if ((alerts & TWAI_ALERT_TX_SUCCESS) != 0u) {
            can->flight = CAN_TWAI_SENT;
        }
    }
    if (twai_get_status_info(&status) == ESP_OK) {
        const uint32_t lost = status.rx_missed_count + status.rx_overrun_count;
        can->counters.dropped = can->counters.dropped + (lost - can->overran);
        can->overran = lost;
    }
}

/** Off the bus, until the driver runs again; once it has recovered it is started. */
static bool is_off(const can_twai_t *const can) {
    twai_status_info_t status;
    (void)can;
    if (twai_get_status_info(&status) != ESP_OK) {
        return false;
    }
    return (status.state != TWAI_STATE_RUNNING) &&
           ((status.state != TWAI_STATE_STOPPED) || (twai_start() != ESP_OK));
}

static void recover(const can_twai_t *const can) {
    (void)can;
    (void)twai_initiate_recovery();
}

void can_twai_rest(can_twai_t *const can) {
    uint32_t alerts = 0;
    (void)twai_read_alerts(&alerts, 1);
    can->alerts |= alerts;
}

#endif

int can_twai_start(can_twai_t *const can, const int transmit_pin, const int receive_pin,
                   const can_port_config_t *const config) {
    memset(can, 0, sizeof *can);
    can->cycle_us = config->cycle_us;
    can->task = xTaskGetCurrentTaskHandle();
    if (config->fd) {
        return CAN_PORT_ERROR_FRAME;
    }
    return install(can, transmit_pin, receive_pin, config);
}

static void give_up(can_twai_t *const can) {
    can->flight = CAN_TWAI_NONE;
    can->counters.aborted += 1u;
}

/** Counts what has left; sends again what has not, while it is young. */
static void settle(can_twai_t *const can, const uint32_t now_us) {
    if (can->flight == CAN_TWAI_SENT) {
        can->flight = CAN_TWAI_NONE;
        can->counters.sent += 1u;
    } else if (can->flight == CAN_TWAI_FAILED) {
        if ((now_us - can->handed_us > can->cycle_us) || can->off || !launch(can)) {
            give_up(can);
        }
    }
}

int can_twai_transmit(can_twai_t *const can, const ccgen_frame_t *const frame,
                      const uint32_t now_us) {
    if (frame->fd || (frame->length > 8u)) {
        return CAN_PORT_ERROR_FRAME;
    }
    settle(can, now_us);
    if ((can->flight != CAN_TWAI_NONE) || can->off) {
        return 0;
    }
    prepare(can, frame);
    can->handed_us = now_us;
    return launch(can) ? 1 : 0;
}

/** What flew at bus-off is the driver's until it has recovered, which forgets it. */
static void look_at_bus(can_twai_t *const can) {
    const bool off = is_off(can);
    if (off && !can->off) {
        can->counters.bus_off += 1u;
        recover(can);
    } else if (!off && can->off && (can->flight == CAN_TWAI_FLYING)) {
        give_up(can);
    }
    can->off = off;
}

void can_twai_service(can_twai_t *const can, const uint32_t now_us) {
    fetch(can, now_us);
    if (can->erred) {
        can->erred = false;
        can->counters.errors += 1u;
    }
    look_at_bus(can);
    settle(can, now_us);
}
