/**
 * \file fake.c
 * \brief A kernel and a controller that follow Zephyr's documented interface, for one example.
 *
 * Every millisecond that the program sleeps, what is on the bus goes on: the frame in flight is
 * sent and called back where another node acknowledges, and frames come in through the filters.
 * Those come from standard input, a line each: when (ms), identifier, flags, DLC, data. What is
 * sent goes to standard output in the same form. FAKE_ALONE=FROM-TO (ms): nobody acknowledges then;
 * FAKE_OFF=FROM-TO: the controller is in bus-off; FAKE_END: when the program ends. A call that
 * would wait where nobody acknowledges ends it as wrong.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../must.h"
#include <zephyr/drivers/can.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/atomic.h>

#define FILTERS 14

const struct device fake_bus = {"can"};

static const uint8_t lengths[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

static struct {
    int64_t us;
    bool started;
    can_mode_t mode;
    const struct can_frame *flying; /* the program's: it must not change before the callback */
    struct can_frame copy;
    can_tx_callback_t callback;
    void *context;
    int filters;
    struct can_filter filter[FILTERS];
    can_rx_callback_t arrived;
    bool line;
    long due_ms;
    unsigned sent;
} fake;

static bool within(const char *const name) {
    const char *const span = getenv(name);
    long from = 0;
    long to = 0;
    return (span != NULL) && (sscanf(span, "%ld-%ld", &from, &to) == 2) &&
           (fake.us / 1000 >= from) && (fake.us / 1000 < to);
}

bool device_is_ready(const struct device *const device) {
    return device == &fake_bus;
}

atomic_val_t atomic_get(const atomic_t *const target) {
    return *target;
}

atomic_val_t atomic_set(atomic_t *const target, const atomic_val_t value) {
    const atomic_val_t old = *target;
    *target = value;
    return old;
}

int64_t k_uptime_ticks(void) {
    fake.us += 1;
    return fake.us;
}

uint64_t k_ticks_to_us_floor64(const uint64_t ticks) {
    return ticks;
}

uint8_t can_dlc_to_bytes(const uint8_t dlc) {
    return lengths[dlc < 15u ? dlc : 15u];
}

uint8_t can_bytes_to_dlc(const uint8_t bytes) {
    uint8_t dlc = 0;
    while ((dlc < 15u) && (lengths[dlc] < bytes)) {
        ++dlc;
    }
    return dlc;
}

int can_set_mode(const struct device *const device, const can_mode_t mode) {
    CHECK(device == &fake_bus);
    if (fake.started) {
        return -EBUSY;
    }
    if ((mode & ~CAN_MODE_FD) != 0u || (CAN_MAX_DLEN < 64U && mode != 0u)) {
        return -ENOTSUP;
    }
    fake.mode = mode;
    return 0;
}

int can_start(const struct device *const device) {
    CHECK(device == &fake_bus);
    if (fake.started) {
        return -EALREADY;
    }
    fake.started = true;
    return 0;
}

static void land(const int error) {
    CHECK(memcmp(fake.flying, &fake.copy, sizeof fake.copy) == 0);
    fake.flying = NULL;
    fake.callback(&fake_bus, error, fake.context);
}

int can_stop(const struct device *const device) {
    CHECK(device == &fake_bus);
    if (!fake.started) {
        return -EALREADY;
    }
    fake.started = false;
    if (fake.flying != NULL) {
        land(-ENETDOWN);
    }
    return 0;
}

int can_add_rx_filter(const struct device *const device, const can_rx_callback_t callback,
                      void *const context, const struct can_filter *const filter) {
    CHECK((device == &fake_bus) && (callback != NULL) && (context == NULL));
    if (fake.filters == FILTERS) {
        return -ENOSPC;
    }
    fake.arrived = callback;
    fake.filter[fake.filters] = *filter;
    return fake.filters++;
}

int can_send(const struct device *const device, const struct can_frame *const frame,
             const k_timeout_t timeout, const can_tx_callback_t callback, void *const context) {
    const bool fd = (frame->flags & CAN_FRAME_FDF) != 0u;
    CHECK(device == &fake_bus);
    CHECK((callback != NULL) && (timeout.ms == 0)); /* else it would wait */
    CHECK(((frame->flags & CAN_FRAME_IDE) != 0u) || (frame->id <= 0x7FFu));
    if ((frame->dlc > 15u) || (!fd && (frame->dlc > 8u))) {
        return -EINVAL;
    }
    if (fd && ((fake.mode & CAN_MODE_FD) == 0u)) {
        return -ENOTSUP;
    }
    if (!fake.started) {
        return -ENETDOWN;
    }
    if (within("FAKE_OFF")) {
        return -ENETUNREACH;
    }
    if (fake.flying != NULL) {
        return -EAGAIN;
    }
    fake.flying = frame;
    fake.copy = *frame;
    fake.callback = callback;
    fake.context = context;
    return 0;
}

static void write_frame(const struct can_frame *const frame) {
    (void)printf("%ld %x %x %u ", (long)(fake.us / 1000), (unsigned)frame->id, frame->flags,
                 frame->dlc);
    for (unsigned i = 0; i < can_dlc_to_bytes(frame->dlc); ++i) {
        (void)printf("%02x", frame->data[i]);
    }
    (void)printf("\n");
}

/** What the bus does in a millisecond: at most some frames out. */
static void pass(void) {
    if ((fake.flying != NULL) && within("FAKE_OFF")) {
        land(-ENETUNREACH);
    }
    if ((fake.flying != NULL) && !within("FAKE_ALONE")) {
        write_frame(fake.flying);
        land(0);
    }
}

static void take(struct can_frame *const frame) {
    for (int i = 0; i < fake.filters; ++i) {
        const struct can_filter *const filter = &fake.filter[i];
        const bool kind = ((filter->flags & CAN_FILTER_IDE) != 0u) ==
                          ((frame->flags & CAN_FRAME_IDE) != 0u);
        if (fake.started && kind && (((frame->id ^ filter->id) & filter->mask) == 0u)) {
            fake.arrived(&fake_bus, frame, NULL);
            return;
        }
    }
}

/** Lets in what is due by now. */
static void let_in(void) {
    char data[129];
    unsigned id = 0;
    unsigned flags = 0;
    unsigned dlc = 0;
    for (;;) {
        if (!fake.line) {
            fake.line = scanf("%ld", &fake.due_ms) == 1;
        }
        if (!fake.line || (fake.due_ms > fake.us / 1000)) {
            return;
        }
        CHECK(scanf("%x %x %u %128s", &id, &flags, &dlc, data) == 4);
        fake.line = false;
        struct can_frame frame;
        memset(&frame, 0, sizeof frame);
        frame.id = id;
        frame.flags = (uint8_t)flags;
        frame.dlc = (uint8_t)dlc;
        for (size_t i = 0; (i < CAN_MAX_DLEN) && (2u * i + 1u < strlen(data)); ++i) {
            unsigned byte = 0;
            CHECK(sscanf(&data[2u * i], "%2x", &byte) == 1);
            frame.data[i] = (uint8_t)byte;
        }
        take(&frame);
    }
}

int k_sem_take(struct k_sem *const sem, const k_timeout_t timeout) {
    CHECK(timeout.ms == 1); /* the program looks at its clock again */
    if (sem->count == 0u) {
        fake.us += 100;
    }
    fake.us += 100;
    pass();
    let_in();
    if (fake.us / 1000 > strtol(getenv("FAKE_END"), NULL, 10)) {
        exit(0);
    }
    if (sem->count > 0u) {
        sem->count -= 1u;
        return 0;
    }
    fake.us += 800;
    return -EAGAIN;
}

void k_sem_give(struct k_sem *const sem) {
    sem->count += (sem->count < sem->limit) ? 1u : 0u;
}
