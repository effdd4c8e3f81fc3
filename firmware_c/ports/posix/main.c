/**
 * \file main.c
 * \brief The joint as a process that speaks SLCAN over a byte stream (POSIX).
 *
 *     node [--window-ms N] [--patient] [--fd N | DEVICE]
 *
 * Without a device it speaks on standard input and output. port_joint.h, generated for each joint,
 * gives port_node_t with port_node_init, port_node_receive, port_node_transmit and
 * port_node_set_window. A frame's time is that of reading the block it came in. With --patient a
 * snapshot has the widest window and a cycle of the clock lasts a tenth of a second at least: for
 * tests, which must not depend on how busy the machine is.
 *
 * Memory is fixed: one block of input, one of output. While the output is full nothing is read, so
 * a host that does not listen stalls the line instead of losing frames. Ends with status 0 at the
 * end of input, when the other side hangs up, and at SIGTERM or SIGINT; 1 on an error of the line;
 * 2 on wrong arguments.
 */
#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include "ccgen/slcan.h"
#include "port_joint.h"

#define BLOCK 65536u
#define TICK_MS 1
#define WINDOW_MS_MAX ((long)(PORT_WINDOW_MAX_US / 1000u))
#define PATIENT_SLOW ((100000u + PORT_CYCLE_US - 1u) / PORT_CYCLE_US)

enum { EXIT_LINE = 1, EXIT_USAGE = 2 };

/** What came of moving bytes. */
typedef enum { LINE_OPEN, LINE_ENDED, LINE_FAILED } line_t;

/** Bytes [begin, end) of a block wait to be processed or written. */
typedef struct {
    size_t begin;
    size_t end;
    uint8_t bytes[BLOCK];
} block_t;

typedef struct {
    int in;
    int out;
    bool ended;
    bool pending;     /* the node may have frames to send */
    uint32_t slow;    /* machine's time for one of the clock's */
    uint32_t read_us; /* when the input was read */
    block_t input;
    block_t output;
    ccgen_slcan_t slcan;
    port_node_t node;
} link_t;

typedef struct {
    const char *device;
    int fd;
    uint32_t window_us;
    bool patient;
} options_t;

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

static bool output_has_room(const link_t *const link) {
    return (link->output.end + CCGEN_SLCAN_ENCODED_MAX + CCGEN_SLCAN_REPLY_MAX) <= BLOCK;
}

/** Moves the node's frames to the output; what a closed channel would carry is dropped with it. */
static void fetch_frames(link_t *const link) {
    ccgen_frame_t frame;
    while (link->pending && output_has_room(link)) {
        if (port_node_transmit(&link->node, now_us(link), &frame) != 1) {
            link->pending = false;
        } else if (link->slcan.open) {
            const int length = ccgen_slcan_encode(&frame, &link->output.bytes[link->output.end],
                                                  BLOCK - link->output.end);
            link->output.end += (length > 0) ? (size_t)length : 0u;
        }
    }
}

static void take_byte(link_t *const link) {
    ccgen_frame_t frame;
    const uint8_t byte = link->input.bytes[link->input.begin];
    ++link->input.begin;
    const int result = ccgen_slcan_feed(&link->slcan, byte, &frame);
    memcpy(&link->output.bytes[link->output.end], link->slcan.reply, link->slcan.reply_length);
    link->output.end += link->slcan.reply_length;
    if (result == 1) {
        (void)port_node_receive(&link->node, &frame, link->read_us);
        link->pending = true;
    }
}

/** Processes input until it is used up or the output is full. */
static void process(link_t *const link) {
    fetch_frames(link);
    while ((link->input.begin < link->input.end) && !link->pending && output_has_room(link)) {
        take_byte(link);
        fetch_frames(link);
    }
}

static bool input_is_used_up(const link_t *const link) {
    return link->input.begin == link->input.end;
}

static line_t read_input(link_t *const link) {
    const ssize_t count = read(link->in, link->input.bytes, BLOCK);
    if (count > 0) {
        link->input.begin = 0;
        link->input.end = (size_t)count;
        link->read_us = now_us(link);
        return LINE_OPEN;
    }
    if ((count < 0) && is_passing(errno)) {
        return LINE_OPEN;
    }
    /* A pseudo-terminal whose other side is closed reports EIO. */
    return ((count == 0) || (errno == EIO)) ? LINE_ENDED : LINE_FAILED;
}

static line_t write_output(link_t *const link) {
    block_t *const output = &link->output;
    const ssize_t count =
        write(link->out, &output->bytes[output->begin], output->end - output->begin);
    if (count < 0) {
        if (is_passing(errno)) {
            return LINE_OPEN;
        }
        return ((errno == EPIPE) || (errno == EIO)) ? LINE_ENDED : LINE_FAILED;
    }
    output->begin += (size_t)count;
    memmove(output->bytes, &output->bytes[output->begin], output->end - output->begin);
    output->end -= output->begin;
    output->begin = 0;
    return LINE_OPEN;
}

/** Waits until something can be done, at most a tick, and moves bytes. */
static line_t move_bytes(link_t *const link) {
    const bool reads = !link->ended && input_is_used_up(link);
    const bool writes = (link->output.end > 0u);
    struct pollfd files[2] = {{reads ? link->in : -1, POLLIN, 0},
                              {writes ? link->out : -1, POLLOUT, 0}};
    if (poll(files, 2, TICK_MS) < 0) {
        return (errno == EINTR) ? LINE_OPEN : LINE_FAILED;
    }
    if ((files[1].revents & (POLLERR | POLLHUP)) != 0) {
        return LINE_ENDED; /* nobody is left to read */
    }
    if (files[1].revents != 0) {
        const line_t written = write_output(link);
        if (written != LINE_OPEN) {
            return written;
        }
    }
    if (files[0].revents != 0) {
        const line_t line = read_input(link);
        link->ended = (line == LINE_ENDED);
        return (line == LINE_FAILED) ? LINE_FAILED : LINE_OPEN;
    }
    return LINE_OPEN;
}

/** Runs until the line ends or a signal asks to stop. */
static line_t run(link_t *const link) {
    line_t line = LINE_OPEN;
    while ((line == LINE_OPEN) && (stop_requested == 0)) {
        line = move_bytes(link);
        process(link);
        if (link->ended && input_is_used_up(link) && !link->pending && (link->output.end == 0u)) {
            return LINE_ENDED;
        }
        link->pending = link->pending || !link->ended;
    }
    return line;
}

static void print_usage(FILE *const to, const char *const program) {
    (void)fprintf(to,
                  "usage: %s [--window-ms N] [--patient] [--fd N | DEVICE]\n\n"
                  "The joint's CAN node, speaking SLCAN.\n\n"
                  "  DEVICE         terminal or pseudo-terminal, put into raw mode; without it\n"
                  "                 standard input and output\n"
                  "  --fd N         an open file descriptor for both directions\n"
                  "  --window-ms N  time within which the frames of a snapshot must arrive, 1 to\n"
                  "                 %ld\n"
                  "  --patient      the widest window and a slow clock, for tests\n"
                  "  --help         this text\n",
                  program, WINDOW_MS_MAX);
}

/** \return whether `text` is a whole number from `low` to `high`. */
static bool read_number(const char *const text, const long low, const long high,
                        long *const number) {
    char *end = NULL;
    errno = 0;
    *number = strtol(text, &end, 10);
    return (errno == 0) && (end != text) && (*end == '\0') && (*number >= low) && (*number <= high);
}

/** \return whether the arguments make sense; says on standard error which does not. */
static bool read_options(const int argc, char *const argv[], options_t *const options) {
    for (int i = 1; i < argc; ++i) {
        long number = 0;
        const char *const value = ((i + 1) < argc) ? argv[i + 1] : "";
        if (strcmp(argv[i], "--fd") == 0) {
            if (!read_number(value, 0, 65535, &number)) {
                (void)fprintf(stderr, "%s: --fd needs an open file descriptor\n", argv[0]);
                return false;
            }
            options->fd = (int)number;
            ++i;
        } else if (strcmp(argv[i], "--window-ms") == 0) {
            if (!read_number(value, 1, WINDOW_MS_MAX, &number)) {
                (void)fprintf(stderr, "%s: --window-ms needs 1 to %ld\n", argv[0], WINDOW_MS_MAX);
                return false;
            }
            options->window_us = (uint32_t)number * 1000u;
            ++i;
        } else if (strcmp(argv[i], "--patient") == 0) {
            options->patient = true;
        } else if ((argv[i][0] == '-') || (options->device != NULL)) {
            (void)fprintf(stderr, "%s: unknown argument %s; see --help\n", argv[0], argv[i]);
            return false;
        } else {
            options->device = argv[i];
        }
    }
    return true;
}

/** Raw mode: bytes pass as they are, one by one. */
static int make_raw(const int fd) {
    struct termios settings;
    if (tcgetattr(fd, &settings) != 0) {
        return -1;
    }
    settings.c_iflag &=
        (tcflag_t) ~(IGNBRK | BRKINT | PARMRK | ISTRIP | INLCR | IGNCR | ICRNL | IXON | IXOFF);
    settings.c_oflag &= (tcflag_t)~OPOST;
    settings.c_lflag &= (tcflag_t) ~(ECHO | ECHONL | ICANON | ISIG | IEXTEN);
    settings.c_cflag &= (tcflag_t) ~(CSIZE | PARENB);
    settings.c_cflag |= (tcflag_t)(CS8 | CLOCAL | CREAD);
    settings.c_cc[VMIN] = 1;
    settings.c_cc[VTIME] = 0;
    return tcsetattr(fd, TCSANOW, &settings);
}

/** Opens both directions. \return whether that worked; says on standard error what did not. */
static bool open_line(const options_t *const options, link_t *const link) {
    const char *const name = (options->device != NULL) ? options->device : "line";
    link->in = (options->fd >= 0) ? options->fd : STDIN_FILENO;
    link->out = (options->fd >= 0) ? options->fd : STDOUT_FILENO;
    if (options->device != NULL) {
        link->in = open(options->device, O_RDWR | O_NOCTTY | O_NONBLOCK);
        link->out = link->in;
        if ((link->in < 0) || (make_raw(link->in) != 0)) {
            (void)fprintf(stderr, "%s: cannot be used as a terminal: %s\n", name, strerror(errno));
            return false;
        }
    }
    return true;
}

/** \return the flags of a file before it was made non-blocking, or -1. */
static int make_non_blocking(const int fd) {
    const int flags = fcntl(fd, F_GETFL);
    return ((flags >= 0) && (fcntl(fd, F_SETFL, flags | O_NONBLOCK) >= 0)) ? flags : -1;
}

static void catch_signals(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = request_stop;
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGINT, &action, NULL);
    action.sa_handler = SIG_IGN;
    (void)sigaction(SIGPIPE, &action, NULL);
}

/** Serves the line and leaves its files as they were. */
static int serve(link_t *const link) {
    const int in_flags = make_non_blocking(link->in);
    const int out_flags = make_non_blocking(link->out);
    const bool usable = (in_flags >= 0) && (out_flags >= 0);
    const line_t line = usable ? run(link) : LINE_FAILED;
    if (line == LINE_FAILED) {
        (void)fprintf(stderr, "line: %s\n", strerror(errno));
    }
    if (usable) {
        (void)fcntl(link->out, F_SETFL, out_flags);
        (void)fcntl(link->in, F_SETFL, in_flags);
    }
    return (line == LINE_FAILED) ? EXIT_LINE : EXIT_SUCCESS;
}

int main(int argc, char *argv[]) {
    static link_t link; /* too large for a stack */
    options_t options = {NULL, -1, 0, false};
    if ((argc == 2) && (strcmp(argv[1], "--help") == 0)) {
        print_usage(stdout, argv[0]);
        return EXIT_SUCCESS;
    }
    if (!read_options(argc, argv, &options)) {
        return EXIT_USAGE;
    }
    (void)port_node_init(&link.node);
    (void)ccgen_slcan_init(&link.slcan);
    link.slow = options.patient ? PATIENT_SLOW : 1u;
    if (options.patient) {
        options.window_us = PORT_WINDOW_MAX_US;
    }
    if (options.window_us != 0u) {
        (void)port_node_set_window(&link.node, options.window_us);
    }
    if (!open_line(&options, &link)) {
        return EXIT_USAGE;
    }
    catch_signals();
    return serve(&link);
}
