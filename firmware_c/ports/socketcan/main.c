/**
 * \file main.c
 * \brief The joint as a node on a Linux CAN interface, real or virtual.
 *
 *     node INTERFACE
 *
 * port_joint.h, generated for each joint, gives port_node_t with port_node_init, port_node_receive
 * and port_node_transmit. A frame that the interface cannot take yet is kept, and nothing is read
 * until it has gone. Ends with status 0 at SIGTERM or SIGINT; 1 on an error of the interface; 2 on
 * wrong arguments.
 */
#if !defined(_GNU_SOURCE)
#define _GNU_SOURCE
#endif

#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "port_joint.h"

#define TICK_MS 1

enum { EXIT_INTERFACE = 1, EXIT_USAGE = 2 };

static volatile sig_atomic_t stop_requested = 0;

static void request_stop(const int signal_number) {
    (void)signal_number;
    stop_requested = 1;
}

static uint32_t now_us(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint32_t)((uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u);
}

/** \return a bound socket, or -1 with errno set. */
static int open_interface(const char *const name) {
    const int enable = 1;
    struct sockaddr_can address;
    memset(&address, 0, sizeof address);
    address.can_family = AF_CAN;
    address.can_ifindex = (int)if_nametoindex(name);
    if (address.can_ifindex == 0) {
        return -1;
    }
    const int can = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
    if (can < 0) {
        return -1;
    }
    /* Classic frames pass either way; where FD frames cannot, sending one reports it. */
    (void)setsockopt(can, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &enable, sizeof enable);
    if (bind(can, (const struct sockaddr *)&address, sizeof address) != 0) {
        const int error = errno;
        (void)close(can);
        errno = error;
        return -1;
    }
    return can;
}

static void from_wire(const struct canfd_frame *const wire, const bool fd,
                      ccgen_frame_t *const frame) {
    frame->extended = (wire->can_id & CAN_EFF_FLAG) != 0u;
    frame->id = wire->can_id & (frame->extended ? CAN_EFF_MASK : CAN_SFF_MASK);
    frame->fd = fd;
    frame->remote = (wire->can_id & CAN_RTR_FLAG) != 0u;
    frame->rate_switch = fd && ((wire->flags & CANFD_BRS) != 0u);
    frame->length = wire->len;
    memcpy(frame->data, wire->data, wire->len);
}

static void to_wire(const ccgen_frame_t *const frame, struct canfd_frame *const wire) {
    memset(wire, 0, sizeof *wire);
    wire->can_id = frame->id | (frame->extended ? CAN_EFF_FLAG : 0u);
    wire->len = frame->length;
    memcpy(wire->data, frame->data, frame->length);
}

/** \return 1: frame read; 0: none there; -1: errno says what is wrong. */
static int read_frame(const int can, ccgen_frame_t *const frame) {
    struct canfd_frame wire;
    const ssize_t count = read(can, &wire, sizeof wire);
    if (count < 0) {
        return ((errno == EAGAIN) || (errno == EWOULDBLOCK) || (errno == EINTR)) ? 0 : -1;
    }
    const bool fd = ((size_t)count == CANFD_MTU);
    const bool whole = fd || ((size_t)count == CAN_MTU);
    if (!whole || (wire.len > (fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) ||
        ((wire.can_id & CAN_ERR_FLAG) != 0u)) {
        return 0;
    }
    from_wire(&wire, fd, frame);
    return 1;
}

/** \return 1: sent; 0: the interface is busy, try again; -1: errno says what is wrong. */
static int write_frame(const int can, const ccgen_frame_t *const frame) {
    struct canfd_frame wire;
    to_wire(frame, &wire);
    if (write(can, &wire, frame->fd ? CANFD_MTU : CAN_MTU) >= 0) {
        return 1;
    }
    const bool busy =
        (errno == EAGAIN) || (errno == EWOULDBLOCK) || (errno == ENOBUFS) || (errno == EINTR);
    return busy ? 0 : -1;
}

/** Sends what is due. \return 1: all of it; 0: `frame` is kept for later; -1: error. */
static int send_due(const int can, port_node_t *const node, ccgen_frame_t *const frame,
                    bool *const kept) {
    while (*kept || (port_node_transmit(node, now_us(), frame) == 1)) {
        const int sent = write_frame(can, frame);
        *kept = (sent == 0);
        if (sent != 1) {
            return sent;
        }
    }
    return 1;
}

/** Answers every frame that is there. \return -1 on an error. */
static int answer_all(const int can, port_node_t *const node, ccgen_frame_t *const outgoing,
                      bool *const kept) {
    ccgen_frame_t incoming;
    int sent = send_due(can, node, outgoing, kept);
    while (sent == 1) {
        const int got = read_frame(can, &incoming);
        if (got <= 0) {
            return got;
        }
        (void)port_node_receive(node, &incoming, now_us());
        sent = send_due(can, node, outgoing, kept);
    }
    return sent;
}

/** Runs until a signal asks to stop. \return -1 on an error, errno set. */
static int run(const int can, port_node_t *const node) {
    ccgen_frame_t outgoing;
    bool kept = false;
    while (stop_requested == 0) {
        struct pollfd file = {kept ? -1 : can, POLLIN, 0};
        if ((poll(&file, 1, TICK_MS) < 0) && (errno != EINTR)) {
            return -1;
        }
        if (answer_all(can, node, &outgoing, &kept) < 0) {
            return -1;
        }
    }
    return 0;
}

static void catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = request_stop;
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
}

int main(int argc, char *argv[]) {
    port_node_t node;
    if ((argc != 2) || (argv[1][0] == '-')) {
        const bool asked = (argc == 2) && (strcmp(argv[1], "--help") == 0);
        (void)fprintf(asked ? stdout : stderr, "usage: %s INTERFACE\n", argv[0]);
        return asked ? EXIT_SUCCESS : EXIT_USAGE;
    }
    const int can = open_interface(argv[1]);
    if (can < 0) {
        (void)fprintf(stderr, "%s: cannot be opened: %s\n", argv[1], strerror(errno));
        return EXIT_USAGE;
    }
    catch_signals();
    (void)port_node_init(&node);
    const int result = run(can, &node);
    if (result < 0) {
        (void)fprintf(stderr, "%s: %s\n", argv[1], strerror(errno));
    }
    (void)close(can);
    return (result < 0) ? EXIT_INTERFACE : EXIT_SUCCESS;
}
