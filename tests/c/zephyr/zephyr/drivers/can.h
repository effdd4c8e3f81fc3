/** Stand-in for Zephyr's header (3.7): controllers, as far as examples use them. */
#ifndef FAKE_ZEPHYR_CAN_H
#define FAKE_ZEPHYR_CAN_H

#include <zephyr/device.h>
#include <zephyr/kernel.h>

#ifdef CONFIG_CAN_FD_MODE
#define CAN_MAX_DLEN 64U
#else
#define CAN_MAX_DLEN 8U
#endif

#define CAN_FRAME_IDE 0x01U
#define CAN_FRAME_RTR 0x02U
#define CAN_FRAME_FDF 0x04U
#define CAN_FRAME_BRS 0x08U

#define CAN_FILTER_IDE 0x01U

#define CAN_MODE_FD 0x04U

struct can_frame {
    uint32_t id;
    uint8_t dlc;
    uint8_t flags;
    uint8_t data[CAN_MAX_DLEN];
};

struct can_filter {
    uint32_t id;
    uint32_t mask;
    uint8_t flags;
};

typedef uint32_t can_mode_t;
typedef void (*can_tx_callback_t)(const struct device *device, int error, void *context);
typedef void (*can_rx_callback_t)(const struct device *device, struct can_frame *frame,
                                  void *context);

uint8_t can_dlc_to_bytes(uint8_t dlc);
uint8_t can_bytes_to_dlc(uint8_t bytes);
int can_set_mode(const struct device *device, can_mode_t mode);
int can_start(const struct device *device);
int can_stop(const struct device *device);
int can_send(const struct device *device, const struct can_frame *frame, k_timeout_t timeout,
             can_tx_callback_t callback, void *context);
int can_add_rx_filter(const struct device *device, can_rx_callback_t callback, void *context,
                      const struct can_filter *filter);

#endif
