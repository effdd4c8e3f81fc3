/** Stand-in for ESP-IDF's headers, in own words, as far as the port and the example use them. */
#ifndef FAKE_IDF_H
#define FAKE_IDF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define ESP_IDF_VERSION_VAL(major, minor, patch) (((major) << 16) | ((minor) << 8) | (patch))

typedef int esp_err_t;
enum { ESP_OK = 0, ESP_FAIL = -1, ESP_ERR_NO_MEM = 0x101, ESP_ERR_INVALID_ARG, ESP_ERR_INVALID_STATE,
       ESP_ERR_TIMEOUT = 0x107 };

typedef int gpio_num_t;

typedef void *TaskHandle_t;
typedef int BaseType_t;
typedef uint32_t TickType_t;
#define pdFALSE 0
#define pdTRUE 1

TaskHandle_t xTaskGetCurrentTaskHandle(void);
void vTaskNotifyGiveFromISR(TaskHandle_t task, BaseType_t *woken);
uint32_t ulTaskNotifyTake(BaseType_t clear, TickType_t ticks);
int64_t esp_timer_get_time(void);
void app_main(void);

/* The node API of 5.5. */

typedef struct twai_node_base *twai_node_handle_t;
typedef enum {
    TWAI_ERROR_ACTIVE,
    TWAI_ERROR_WARNING,
    TWAI_ERROR_PASSIVE,
    TWAI_ERROR_BUS_OFF
} twai_error_state_t;

typedef struct {
    uint32_t bitrate;
    uint16_t sp_permill;
    uint16_t ssp_permill;
} twai_timing_basic_config_t;

typedef struct {
    struct {
        gpio_num_t tx;
        gpio_num_t rx;
        gpio_num_t quanta_clk_out;
        gpio_num_t bus_off_indicator;
    } io_cfg;
    twai_timing_basic_config_t bit_timing;
    twai_timing_basic_config_t data_timing;
    int8_t fail_retry_cnt;
    uint32_t tx_queue_depth;
} twai_onchip_node_config_t;

typedef struct {
    uint32_t id;
    uint32_t mask;
    uint32_t is_ext : 1;
} twai_mask_filter_config_t;

typedef struct {
    uint32_t id;
    uint16_t dlc;
    uint32_t ide : 1;
    uint32_t rtr : 1;
    uint32_t fdf : 1;
    uint32_t brs : 1;
} twai_frame_header_t;

typedef struct {
    twai_frame_header_t header;
    uint8_t *buffer;
    size_t buffer_len;
} twai_frame_t;

typedef struct {
    bool is_tx_success;
    const twai_frame_t *done_tx_frame;
} twai_tx_done_event_data_t;

typedef struct {
    int nothing;
} twai_rx_done_event_data_t;

typedef struct {
    uint32_t err_flags;
} twai_error_event_data_t;

typedef struct {
    bool (*on_tx_done)(twai_node_handle_t node, const twai_tx_done_event_data_t *event, void *context);
    bool (*on_rx_done)(twai_node_handle_t node, const twai_rx_done_event_data_t *event, void *context);
    bool (*on_error)(twai_node_handle_t node, const twai_error_event_data_t *event, void *context);
} twai_event_callbacks_t;

typedef struct {
    twai_error_state_t state;
    uint16_t tx_error_count;
    uint16_t rx_error_count;
} twai_node_status_t;

typedef struct {
    uint32_t bus_err_num;
} twai_node_record_t;

esp_err_t twai_new_node_onchip(const twai_onchip_node_config_t *config, twai_node_handle_t *node);
esp_err_t twai_node_config_mask_filter(twai_node_handle_t node, uint8_t id,
                                       const twai_mask_filter_config_t *config);
esp_err_t twai_node_register_event_callbacks(twai_node_handle_t node,
                                             const twai_event_callbacks_t *callbacks, void *context);
esp_err_t twai_node_enable(twai_node_handle_t node);
esp_err_t twai_node_delete(twai_node_handle_t node);
esp_err_t twai_node_recover(twai_node_handle_t node);
esp_err_t twai_node_get_info(twai_node_handle_t node, twai_node_status_t *status,
                             twai_node_record_t *record);
esp_err_t twai_node_transmit(twai_node_handle_t node, const twai_frame_t *frame, int timeout_ms);
esp_err_t twai_node_receive_from_isr(twai_node_handle_t node, twai_frame_t *frame);

/* The driver before it. */

enum {
    TWAI_ALERT_TX_SUCCESS = 0x2,
    TWAI_ALERT_RX_DATA = 0x4,
    TWAI_ALERT_BUS_RECOVERED = 0x40,
    TWAI_ALERT_BUS_ERROR = 0x200,
    TWAI_ALERT_TX_FAILED = 0x400,
    TWAI_ALERT_BUS_OFF = 0x2000
};
#define TWAI_IO_UNUSED (-1)

typedef enum { TWAI_MODE_NORMAL } twai_mode_t;
typedef enum {
    TWAI_STATE_STOPPED,
    TWAI_STATE_RUNNING,
    TWAI_STATE_BUS_OFF,
    TWAI_STATE_RECOVERING
} twai_state_t;

typedef struct {
    twai_mode_t mode;
    gpio_num_t tx_io;
    gpio_num_t rx_io;
    gpio_num_t clkout_io;
    gpio_num_t bus_off_io;
    uint32_t tx_queue_len;
    uint32_t rx_queue_len;
    uint32_t alerts_enabled;
} twai_general_config_t;

typedef struct {
    uint32_t quanta_resolution_hz;
    uint32_t brp;
    uint8_t tseg_1;
    uint8_t tseg_2;
    uint8_t sjw;
} twai_timing_config_t;

typedef struct {
    uint32_t acceptance_code;
    uint32_t acceptance_mask;
    bool single_filter;
} twai_filter_config_t;

typedef struct {
    uint32_t extd : 1;
    uint32_t rtr : 1;
    uint32_t ss : 1;
    uint32_t identifier;
    uint8_t data_length_code;
    uint8_t data[8];
} twai_message_t;

typedef struct {
    twai_state_t state;
    uint32_t rx_missed_count;
    uint32_t rx_overrun_count;
} twai_status_info_t;

esp_err_t twai_driver_install(const twai_general_config_t *general,
                              const twai_timing_config_t *timing,
                              const twai_filter_config_t *filter);
esp_err_t twai_driver_uninstall(void);
esp_err_t twai_start(void);
esp_err_t twai_initiate_recovery(void);
esp_err_t twai_transmit(const twai_message_t *message, TickType_t ticks);
esp_err_t twai_receive(twai_message_t *message, TickType_t ticks);
esp_err_t twai_read_alerts(uint32_t *alerts, TickType_t ticks);
esp_err_t twai_get_status_info(twai_status_info_t *status);

#endif
