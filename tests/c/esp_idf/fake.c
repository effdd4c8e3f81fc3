/**
 * \file fake.c
 * \brief ESP-IDF's TWAI drivers as their documentation has them, on a model of a bus.
 *
 * What a driver's interface forbids ends the program: waiting, a frame that changes while it is the
 * driver's, a call in the wrong state.
 */
#include <string.h>

#include "bus.h"
#include "can_twai.h"
#include "must.h"

#define RECOVERY 15u /* steps: 128 times 11 bits at 1 Mbit/s */

extern can_twai_t can; /* the example's own, made visible */

static struct {
    bus_frame_t flying;
    bool flies;
    bool running;
    bool off;
    uint32_t recovering;
    uint32_t tec;
    uint32_t code; /* filter: bits, and which count */
    uint32_t mask;
    bool extended;
    bool woken;
#if CAN_TWAI_NODE
    const twai_frame_t *frame;
    twai_event_callbacks_t callbacks;
    void *context;
    const bus_frame_t *arrived;
#else
    twai_message_t queue[CCGEN_QUEUE_PLACES];
    uint32_t waiting;
    uint32_t alerts;
    uint32_t missed;
    bool stopped; /* recovered, to be started */
#endif
} twai;

TaskHandle_t xTaskGetCurrentTaskHandle(void) {
    bus_counters = &can.counters;
    return &twai;
}

int64_t esp_timer_get_time(void) {
    bus_pass(10u);
    return bus_time_us();
}

static void sleep_a_tick(void) {
    for (int i = 0; (i < 10) && !twai.woken; ++i) {
        bus_pass(100u);
    }
    twai.woken = false;
}

/** A frame of others, through the filter: no matter of whose kind its identifier is. */
static bool is_let_in(const bus_frame_t *const in) {
    const bool extended = (in->flags & BUS_EXTENDED) != 0u;
    return (extended == twai.extended) && (((in->id ^ twai.code) & twai.mask) == 0u) &&
           ((in->flags & BUS_FD) == 0u) && twai.running && !twai.off;
}

static void land(bool success);
static void hear(const bus_frame_t *in);
static void err(void);
static void recovered(void);

/** One attempt: sent once, whatever becomes of it. */
static void send(void) {
    const bus_result_t result = bus_send(&twai.flying);
    if (result == BUS_SENT) {
        twai.tec -= (twai.tec > 0u) ? 1u : 0u;
    } else {
        twai.tec += ((result == BUS_DESTROYED) || (twai.tec < 128u)) ? 8u : 0u;
        err();
    }
    twai.off = twai.tec > 255u;
    if (!twai.off) {
        land(result == BUS_SENT);
    }
}

void fake_step(void) {
    bus_frame_t in;
    if (bus_next(&in)) {
        if (is_let_in(&in)) {
            hear(&in);
        }
    } else if (twai.flies && !twai.off && twai.running) {
        send();
    }
    if ((twai.recovering > 0u) && !bus_within("FAKE_OFF") && (--twai.recovering == 0u)) {
        twai.off = false;
        twai.tec = 0u;
        twai.flies = false; /* forgotten */
        recovered();
    }
}

#if CAN_TWAI_NODE

void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *woken) {
    CHECK(task == &twai);
    twai.woken = true;
    *woken = pdTRUE;
}

uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks) {
    CHECK((clear == pdTRUE) && (ticks == 1u));
    sleep_a_tick();
    return 0u;
}

esp_err_t twai_new_node_onchip(const twai_onchip_node_config_t *config, twai_node_handle_t *node) {
    CHECK((config->tx_queue_depth > 0u) && (config->io_cfg.quanta_clk_out == -1));
    *node = (twai_node_handle_t)(void *)&twai;
    return (80000000u % config->bit_timing.bitrate == 0u) ? ESP_OK : ESP_ERR_INVALID_ARG;
}

esp_err_t twai_node_config_mask_filter(twai_node_handle_t node, uint8_t id,
                                       const twai_mask_filter_config_t *config) {
    CHECK((node != NULL) && (id == 0u) && !twai.running);
    CHECK((config->is_ext != 0u) || ((config->id | config->mask) <= 0x7FFu));
    twai.code = config->id;
    twai.mask = config->mask;
    twai.extended = config->is_ext != 0u;
    return ESP_OK;
}

esp_err_t twai_node_register_event_callbacks(twai_node_handle_t node,
                                             const twai_event_callbacks_t *callbacks,
                                             void *context) {
    CHECK((node != NULL) && !twai.running);
    twai.callbacks = *callbacks;
    twai.context = context;
    return ESP_OK;
}

esp_err_t twai_node_enable(twai_node_handle_t node) {
    CHECK((node != NULL) && !twai.running);
    twai.running = true;
    return ESP_OK;
}

esp_err_t twai_node_delete(twai_node_handle_t node) {
    CHECK((node != NULL) && !twai.running);
    return ESP_OK;
}

esp_err_t twai_node_recover(twai_node_handle_t node) {
    CHECK(node != NULL);
    if (!twai.off) {
        return ESP_ERR_INVALID_STATE;
    }
    twai.recovering = RECOVERY;
    return ESP_OK;
}

esp_err_t twai_node_get_info(twai_node_handle_t node, twai_node_status_t *status,
                             twai_node_record_t *record) {
    CHECK((node != NULL) && (record == NULL));
    status->state = twai.off ? TWAI_ERROR_BUS_OFF : TWAI_ERROR_ACTIVE;
    return ESP_OK;
}

static bus_frame_t as_sent(const twai_frame_t *const frame) {
    bus_frame_t out = {0};
    out.id = frame->header.id;
    out.flags = (uint8_t)((frame->header.ide != 0u) ? BUS_EXTENDED : 0);
    out.dlc = (uint8_t)frame->header.dlc;
    memcpy(out.data, frame->buffer, frame->buffer_len);
    return out;
}

esp_err_t twai_node_transmit(twai_node_handle_t node, const twai_frame_t *frame, int timeout_ms) {
    CHECK((node != NULL) && (timeout_ms == 0) && (frame->buffer_len == frame->header.dlc));
    if (twai.off || !twai.running) {
        return ESP_ERR_INVALID_STATE;
    }
    CHECK(!twai.flies);
    twai.flies = true;
    twai.frame = frame;
    twai.flying = as_sent(frame);
    return ESP_OK;
}

esp_err_t twai_node_receive_from_isr(twai_node_handle_t node, twai_frame_t *frame) {
    CHECK((node != NULL) && (twai.arrived != NULL) && (frame->buffer_len == 8u));
    frame->header.id = twai.arrived->id;
    frame->header.ide = twai.extended ? 1u : 0u;
    frame->header.rtr = ((twai.arrived->flags & BUS_REMOTE) != 0u) ? 1u : 0u;
    frame->header.dlc = twai.arrived->dlc;
    memcpy(frame->buffer, twai.arrived->data, 8u);
    return ESP_OK;
}

static void land(const bool success) {
    const bus_frame_t now = as_sent(twai.frame);
    const twai_tx_done_event_data_t event = {success, twai.frame};
    CHECK(memcmp(&now, &twai.flying, sizeof now) == 0); /* it was the driver's */
    twai.flies = false;
    (void)twai.callbacks.on_tx_done((twai_node_handle_t)(void *)&twai, &event, twai.context);
}

static void hear(const bus_frame_t *const in) {
    const twai_rx_done_event_data_t event = {0};
    twai.arrived = in;
    (void)twai.callbacks.on_rx_done((twai_node_handle_t)(void *)&twai, &event, twai.context);
    twai.arrived = NULL;
}

static void err(void) {
    const twai_error_event_data_t event = {1u};
    (void)twai.callbacks.on_error((twai_node_handle_t)(void *)&twai, &event, twai.context);
}

static void recovered(void) {
}

#else

esp_err_t twai_driver_install(const twai_general_config_t *general,
                              const twai_timing_config_t *timing,
                              const twai_filter_config_t *filter) {
    CHECK((general->rx_queue_len == CCGEN_QUEUE_PLACES) && filter->single_filter);
    const uint32_t bits = ~filter->acceptance_mask;
    twai.extended = (bits & 0x001FFFF8u) != 0u; /* more than eleven bits count */
    twai.code = filter->acceptance_code >> (twai.extended ? 3 : 21);
    twai.mask = bits >> (twai.extended ? 3 : 21);
    return (80000000u % timing->quanta_resolution_hz == 0u) ? ESP_OK : ESP_ERR_INVALID_ARG;
}

esp_err_t twai_driver_uninstall(void) {
    return ESP_OK;
}

esp_err_t twai_start(void) {
    if (twai.running && !twai.stopped) {
        return ESP_ERR_INVALID_STATE;
    }
    twai.running = true;
    twai.stopped = false;
    return ESP_OK;
}

esp_err_t twai_initiate_recovery(void) {
    CHECK(twai.off);
    twai.recovering = RECOVERY;
    return ESP_OK;
}

esp_err_t twai_transmit(const twai_message_t *message, TickType_t ticks) {
    CHECK((ticks == 0u) && (message->ss != 0u));
    if (twai.off || twai.stopped || !twai.running) {
        return ESP_ERR_INVALID_STATE;
    }
    if (twai.flies) {
        return ESP_FAIL;
    }
    memset(&twai.flying, 0, sizeof twai.flying);
    twai.flying.id = message->identifier;
    twai.flying.flags = (uint8_t)((message->extd != 0u) ? BUS_EXTENDED : 0);
    twai.flying.dlc = message->data_length_code;
    memcpy(twai.flying.data, message->data, 8u);
    twai.flies = true;
    return ESP_OK;
}

esp_err_t twai_receive(twai_message_t *message, TickType_t ticks) {
    CHECK(ticks == 0u);
    if (twai.waiting == 0u) {
        return ESP_ERR_TIMEOUT;
    }
    *message = twai.queue[0];
    twai.waiting -= 1u;
    memmove(&twai.queue[0], &twai.queue[1], sizeof twai.queue - sizeof twai.queue[0]);
    return ESP_OK;
}

esp_err_t twai_read_alerts(uint32_t *alerts, TickType_t ticks) {
    CHECK(ticks <= 1u);
    if ((ticks == 1u) && (twai.alerts == 0u)) {
        sleep_a_tick();
    }
    *alerts = twai.alerts;
    twai.alerts = 0u;
    twai.woken = false;
    return (*alerts != 0u) ? ESP_OK : ESP_ERR_TIMEOUT;
}

esp_err_t twai_get_status_info(twai_status_info_t *status) {
    status->state = twai.off ? ((twai.recovering > 0u) ? TWAI_STATE_RECOVERING : TWAI_STATE_BUS_OFF)
                             : (twai.stopped ? TWAI_STATE_STOPPED : TWAI_STATE_RUNNING);
    status->rx_missed_count = twai.missed;
    status->rx_overrun_count = 0u;
    return ESP_OK;
}

static void alert(const uint32_t what) {
    twai.alerts |= what;
    twai.woken = true;
}

static void land(const bool success) {
    twai.flies = false;
    alert(success ? TWAI_ALERT_TX_SUCCESS : TWAI_ALERT_TX_FAILED);
}

static void hear(const bus_frame_t *const in) {
    if (twai.waiting == CCGEN_QUEUE_PLACES) {
        twai.missed += 1u;
        return;
    }
    twai_message_t *const to = &twai.queue[twai.waiting];
    twai.waiting += 1u;
    to->identifier = in->id;
    to->extd = twai.extended ? 1u : 0u;
    to->rtr = ((in->flags & BUS_REMOTE) != 0u) ? 1u : 0u;
    to->data_length_code = in->dlc;
    memcpy(to->data, in->data, 8u);
    alert(TWAI_ALERT_RX_DATA);
}

static void err(void) {
    alert(TWAI_ALERT_BUS_ERROR);
}

static void recovered(void) {
    twai.stopped = true;
    alert(TWAI_ALERT_BUS_RECOVERED);
}

#endif

int main(void) {
    app_main();
    return 1;
}
