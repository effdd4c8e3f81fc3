/** Stand-in for Zephyr's header: devices, as far as examples use them. */
#ifndef FAKE_ZEPHYR_DEVICE_H
#define FAKE_ZEPHYR_DEVICE_H

#include <stdbool.h>

struct device {
    const char *name;
};

extern const struct device fake_bus;

#define DT_CHOSEN(name) name
#define DEVICE_DT_GET(node) (&fake_bus)

bool device_is_ready(const struct device *device);

#endif
