/*
 * The shoulder's node on the board's CAN controller: snapshots in; angles, tip and status out.
 */
#include <string.h>

#include <zephyr/device.h>
#include <zephyr/drivers/can.h>
#include <zephyr/kernel.h>

#include "shoulder_can.h"

static const struct device *const bus = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));
static shoulder_node_t node;

CAN_MSGQ_DEFINE(received, 32);

static uint32_t time_us(void) {
    return (uint32_t)k_ticks_to_us_floor64((uint64_t)k_uptime_ticks());
}

static void send_due(void) {
    ccgen_frame_t frame;
    while (shoulder_node_transmit(&node, time_us(), &frame) == 1) {
        struct can_frame out = {.id = frame.id, .dlc = frame.length};
        memcpy(out.data, frame.data, frame.length);
        (void)can_send(bus, &out, K_MSEC(1), NULL, NULL);
    }
}

static void take(const struct can_frame *in) {
    ccgen_frame_t frame = {.id = in->id, .length = in->dlc};
    if (in->dlc <= CAN_MAX_DLC) {
        memcpy(frame.data, in->data, in->dlc);
        (void)shoulder_node_receive(&node, &frame, time_us());
    }
}

int main(void) {
    const struct can_filter every_standard_frame = {.id = 0, .mask = 0};
    shoulder_node_init(&node);
    if (!device_is_ready(bus) || can_start(bus) != 0 ||
        can_add_rx_filter_msgq(bus, &received, &every_standard_frame) < 0) {
        return 0;
    }
    for (;;) {
        struct can_frame in;
        if (k_msgq_get(&received, &in, K_MSEC(1)) == 0) {
            take(&in);
        }
        send_due();
    }
}
