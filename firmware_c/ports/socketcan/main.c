/**
 * \file main.c
 * \brief The joint as a node on a Linux CAN interface, real or virtual.
 *
 *     node [--window-ms N] [--patient] INTERFACE
 *
 * To compile it, in the exported folder:
 *
 *     cc -std=c99 -O2 -Isrc -Iports $(find src -name "*.c") ports/socketcan/main.c -o node
 *
 * port_joint.h, generated for each joint, gives port_node_t with port_node_init, port_node_receive,
 * port_node_transmit, port_node_unsent and port_node_set_window. A frame that the interface cannot
 * take yet goes back to the node, and nothing is read until it has gone. A snapshot's time is taken
 * when its frames are read: a machine that pauses this process or the sender for longer than a
 * cycle needs a wider window. With
 * --patient a snapshot has the widest window and a cycle of the clock lasts a tenth of a second at
 * least: for tests, which must not depend on how busy the machine is.
 * Ends with status 0 at SIGTERM or SIGINT; 1 on an error of the interface; 2 on wrong arguments.
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
#define WINDOW_MS_MAX ((long)(PORT_WINDOW_MAX_US / 1000u))
#define PATIENT_SLOW ((100000u + PORT_CYCLE_US - 1u) / PORT_CYCLE_US)

enum { EXIT_INTERFACE = 1, EXIT_USAGE = 2 };

typedef struct {
    int can;
    uint32_t slow; /* machine's time for one of the clock's */
    bool busy;     /* the interface could not take what is due */
    port_node_t node;
} link_t;

static volatile sig_atomic_t stop_requested = 0;

static void request_stop(const int signal_number) {
    (void)signal_number;
    stop_requested = 1;
}

/** \return whether an error of a call only says: not now. */
static bool is_passing(const int error) {
#if EWOULDBLOCK != EAGAIN
    if (error == EWOULDBLOCK) {
        return true;
    }
#endif
    return (error == EAGAIN) || (error == EINTR);
}

static uint32_t now_us(const link_t *const link) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    const uint64_t machine_us = (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
    return (uint32_t)(machine_us / link->slow);
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
        return is_passing(errno) ? 0 : -1;
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
    return ((errno == ENOBUFS) || is_passing(errno)) ? 0 : -1;
}

/** Sends what is due, as far as the interface takes it. \return -1 on an error. */
static int send_due(link_t *const link) {
    ccgen_frame_t frame;
    link->busy = false;
    while (!link->busy && (port_node_transmit(&link->node, now_us(link), &frame) == 1)) {
        const int sent = write_frame(link->can, &frame);
        if (sent != 1) {
            (void)port_node_unsent(&link->node);
        }
        if (sent < 0) {
            return -1;
        }
        link->busy = (sent == 0);
    }
    return 0;
}

/** Answers every frame that is there, until the interface is busy. \return -1 on an error. */
static int answer_all(link_t *const link) {
    ccgen_frame_t incoming;
    int result = send_due(link);
    while ((result == 0) && !link->busy) {
        const int got = read_frame(link->can, &incoming);
        if (got <= 0) {
            return got;
        }
        (void)port_node_receive(&link->node, &incoming, now_us(link));
        result = send_due(link);
    }
    return result;
}

/** Runs until a signal asks to stop. \return -1 on an error, errno set. */
static int run(link_t *const link) {
    while (stop_requested == 0) {
        struct pollfd file = {link->busy ? -1 : link->can, POLLIN, 0};
        if ((poll(&file, 1, TICK_MS) < 0) && (errno != EINTR)) {
            return -1;
        }
        if (answer_all(link) < 0) {
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

static void print_usage(FILE *const to, const char *const program) {
    (void)fprintf(to,
                  "usage: %s [--window-ms N] [--patient] INTERFACE\n\n"
                  "The joint's CAN node, on a network interface such as can0 or vcan0.\n\n"
                  "  --window-ms N  time within which the frames of a snapshot must arrive, 1 to\n"
                  "                 %ld\n"
                  "  --patient      the widest window and a slow clock, for tests\n"
                  "  --help         this text\n",
                  program, WINDOW_MS_MAX);
}

/** \return whether `text` is a window in milliseconds, which the node then has. */
static bool set_window(link_t *const link, const char *const text) {
    char *end = NULL;
    const long window_ms = strtol(text, &end, 10);
    return (end != text) && (*end == '\0') && (window_ms >= 1) && (window_ms <= WINDOW_MS_MAX) &&
           (port_node_set_window(&link->node, (uint32_t)window_ms * 1000u) == CCGEN_OK);
}

static void be_patient(link_t *const link) {
    link->slow = PATIENT_SLOW;
    (void)port_node_set_window(&link->node, PORT_WINDOW_MAX_US);
}

/** \return the interface's name; NULL after saying on standard error what is wrong. */
static const char *read_arguments(const int argc, char *const argv[], link_t *const link) {
    int next = 1;
    if ((argc > next) && (strcmp(argv[next], "--window-ms") == 0)) {
        if ((argc < 3) || !set_window(link, argv[2])) {
            (void)fprintf(stderr, "%s: --window-ms needs 1 to %ld\n", argv[0], WINDOW_MS_MAX);
            return NULL;
        }
        next = 3;
    } else if ((argc > next) && (strcmp(argv[next], "--patient") == 0)) {
        be_patient(link);
        next = 2;
    }
    if ((argc != (next + 1)) || (argv[next][0] == '-')) {
        (void)fprintf(stderr, "%s: needs one INTERFACE; see --help\n", argv[0]);
        return NULL;
    }
    return argv[next];
}

/** Says what ended the node and what to do about it. */
static void complain(const char *const name, const int error) {
    if (error == ENETDOWN) {
        (void)fprintf(stderr, "%s: is down; `ip link set %s up`\n", name, name);
    } else if (error == EINVAL) { /* what the kernel says to a frame of a size it does not take */
        (void)fprintf(stderr,
                      "%s: takes no CAN FD frames; set it down, then `ip link set %s mtu 72 up` "
                      "if it is virtual, `ip link set %s up type can ... fd on` if not\n",
                      name, name, name);
    } else {
        (void)fprintf(stderr, "%s: %s\n", name, strerror(error));
    }
}

int main(int argc, char *argv[]) {
    static link_t link; /* zero */
    if ((argc == 2) && (strcmp(argv[1], "--help") == 0)) {
        print_usage(stdout, argv[0]);
        return EXIT_SUCCESS;
    }
    link.slow = 1;
    (void)port_node_init(&link.node);
    const char *const name = read_arguments(argc, argv, &link);
    if (name == NULL) {
        return EXIT_USAGE;
    }
    link.can = open_interface(name);
    if (link.can < 0) {
        (void)fprintf(stderr, "%s: cannot be opened: %s\n", name, strerror(errno));
        return EXIT_USAGE;
    }
    catch_signals();
    const int result = run(&link);
    if (result < 0) {
        complain(name, errno);
    }
    (void)close(link.can);
    return (result < 0) ? EXIT_INTERFACE : EXIT_SUCCESS;
}
