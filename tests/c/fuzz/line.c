/**
 * \file line.c
 * \brief Fuzzes the port for POSIX: its whole loop on a line that splits, stalls, fails and hangs
 * up.
 *
 * The port's system calls are replaced. Input arrives in pieces of any size, writes are cut short,
 * calls are interrupted. Whatever happens, every line read gets one answer, in order, and what goes
 * out is whole lines: answers and protected frames of the joint. FUZZ_LAYOUT names its layout.
 */
#define main port_main
#define read line_read
#define write line_write
#define poll line_poll
#define clock_gettime line_clock
int port_main(int argc, char *argv[]);
#include "posix/main.c" /* its static functions are under test */
#include "ccgen/layout_inline.h"
#undef read
#undef write

#include "input.h"

#define STREAM 8192u
#define POLLS_MAX 20000

/** The far end of the line. */
typedef struct {
    input_t input;
    uint64_t now_us;
    size_t begin; /* bytes [begin, end) of the stream are still to be read */
    size_t end;
    uint8_t stream[STREAM];
    uint8_t counter;
    bool deaf;   /* nothing is written for now */
    bool failed; /* an error other than "try again" was reported */
    int polls;
    size_t asked;    /* lines that the port has read */
    size_t answered; /* answers that it has written */
    ccgen_slcan_t slcan;
    uint32_t next; /* index of the frame that must follow; 0 between answers */
    size_t length; /* of the line being written */
    uint8_t line[CCGEN_SLCAN_ENCODED_MAX];
} far_t;

static far_t far_end;
static link_t port;

int line_clock(const clockid_t clock, struct timespec *const now) {
    (void)clock;
    far_end.now_us += 50u;
    now->tv_sec = (time_t)(far_end.now_us / 1000000u);
    now->tv_nsec = (long)(far_end.now_us % 1000000u) * 1000;
    return 0;
}

static void append(const uint8_t *const bytes, const size_t count) {
    for (size_t i = 0; (i < count) && (far_end.end < STREAM); ++i) {
        far_end.stream[far_end.end] = bytes[i];
        ++far_end.end;
    }
}

/** All LENGTHS frames of a snapshot as lines, or all but the last. */
static void append_snapshot(const ccgen_layout_t *const layout, const bool whole) {
    const uint16_t modulus = ccgen_e2e_counter_modulus(ccgen_layout_profile(layout));
    const uint8_t frames = layout->lengths_frames;
    far_end.counter = (uint8_t)((far_end.counter + 1u) % modulus);
    for (uint8_t slot = 0; slot < (frames - (whole ? 0u : 1u)); ++slot) {
        ccgen_frame_t frame = CCGEN_ZERO;
        uint8_t text[CCGEN_SLCAN_ENCODED_MAX];
        ccgen_layout_begin(layout, slot, &frame);
        CHECK(ccgen_layout_protect(layout, far_end.counter, &frame) == CCGEN_OK);
        const int length = ccgen_slcan_encode(&frame, text, sizeof text);
        CHECK(length > 0);
        append(text, (size_t)length);
    }
}

/** Puts something more into the stream. */
static void refill(void) {
    static const uint8_t commands[] = "O\rL\rC\rV\rN\rF\rS6\r\r\n";
    uint8_t any[32];
    const uint8_t what = take8(&far_end.input);
    far_end.begin = 0;
    far_end.end = 0;
    switch (what % 8u) {
        case 0:
        case 1:
            for (size_t i = 0; i < sizeof any; ++i) {
                any[i] = take8(&far_end.input);
            }
            append(any, 1u + what / 8u);
            break;
        case 2:
            append(&commands[2u * (what % 3u)], 2);
            break;
        case 3:
            append(commands, sizeof commands - 1u);
            break;
        case 4:
            append_snapshot(&FUZZ_LAYOUT, false);
            break;
        default:
            append(commands, 2);
            for (uint8_t n = what / 8u; n > 0u; --n) {
                append_snapshot(&FUZZ_LAYOUT, true);
            }
            break;
    }
}

/** Reports one of the errors that a line may have. */
static ssize_t fail(const uint8_t which) {
    static const int errors[] = {EAGAIN, EINTR, EIO, EPIPE, EBADF};
    errno = errors[which % 5u];
    far_end.failed = far_end.failed || ((which % 5u) > 1u);
    return -1;
}

int line_poll(struct pollfd *const files, const nfds_t count, const int wait_ms) {
    CHECK((count == 2u) && (wait_ms >= 0));
    CHECK((port.output.begin <= port.output.end) && (port.output.end <= BLOCK));
    CHECK((port.input.begin <= port.input.end) && (port.input.end <= BLOCK));
    ++far_end.polls;
    CHECK(far_end.polls < POLLS_MAX); /* the end of input ends the port */
    const uint8_t what = take8(&far_end.input);
    far_end.now_us += (uint64_t)(what & 0xF0u) << (what & 0x0Fu);
    if (far_end.input.left == 0u) {
        far_end.deaf = false;
    } else if ((what % 16u) == 1u) {
        far_end.deaf = !far_end.deaf;
    } else if ((what % 16u) == 2u) {
        errno = EINTR;
        return -1;
    }
    files[0].revents = (short)((files[0].fd >= 0) ? POLLIN : 0);
    files[1].revents = (short)(((files[1].fd >= 0) && !far_end.deaf) ? POLLOUT : 0);
    return 1;
}

ssize_t line_read(const int fd, void *const bytes, const size_t capacity) {
    CHECK((fd == port.in) && (capacity == BLOCK));
    const uint8_t what = take8(&far_end.input);
    if (far_end.begin == far_end.end) {
        if (far_end.input.left == 0u) {
            return 0;
        }
        refill();
    }
    if ((what % 64u) == 63u) {
        return fail((uint8_t)(what / 64u + take8(&far_end.input)));
    }
    const size_t waiting = far_end.end - far_end.begin;
    const size_t wanted = ((what % 2u) == 0u) ? waiting : (1u + what / 8u);
    const size_t count = (wanted < waiting) ? wanted : waiting;
    memcpy(bytes, &far_end.stream[far_end.begin], count);
    for (size_t i = 0; i < count; ++i) {
        far_end.asked += (far_end.stream[far_end.begin + i] == '\r') ? 1u : 0u;
    }
    far_end.begin += count;
    return (ssize_t)count;
}

static bool is_answer(const char *const text) {
    return (far_end.length == (strlen(text) + 1u)) &&
           (memcmp(far_end.line, text, far_end.length - 1u) == 0);
}

/** A whole line with its end has come: an answer, or a frame that the joint sends. */
static void take_line(void) {
    ccgen_frame_t frame;
    if ((far_end.line[far_end.length - 1u] == '\a') || is_answer("") || is_answer("V0101") ||
        is_answer("NCCGN") || is_answer("F00")) {
        CHECK((far_end.line[far_end.length - 1u] == '\r') || (far_end.length == 1u));
        ++far_end.answered;
        CHECK(far_end.answered <= far_end.asked);
        return;
    }
    int result = 0;
    for (size_t i = 0; i < far_end.length; ++i) {
        result = ccgen_slcan_feed(&far_end.slcan, far_end.line[i], &frame);
    }
    CHECK(result == 1);
    const uint32_t first = FUZZ_LAYOUT.lengths_frames;
    const uint32_t status = ccgen_layout_status_index(&FUZZ_LAYOUT);
    const uint32_t index = frame.id - FUZZ_LAYOUT.base_id;
    CHECK((index >= first) && (index <= (status + 1u)));
    CHECK((index == first) || (index >= status) || (index == far_end.next));
    CHECK((far_end.next == 0u) || (index == far_end.next)); /* an answer goes out whole */
    far_end.next = (index < status) ? (index + 1u) : 0u;
    CHECK(ccgen_layout_check(&FUZZ_LAYOUT, &frame) >= 0);
}

ssize_t line_write(const int fd, const void *const bytes, const size_t count) {
    const uint8_t *const text = (const uint8_t *)bytes;
    CHECK((fd == port.out) && (count > 0u));
    const uint8_t what = take8(&far_end.input);
    if ((what % 64u) == 63u) {
        return fail((uint8_t)(what / 64u + take8(&far_end.input)));
    }
    const size_t wanted = ((what % 4u) == 0u) ? count : (1u + what);
    const size_t written = (wanted < count) ? wanted : count;
    for (size_t i = 0; i < written; ++i) {
        CHECK(far_end.length < sizeof far_end.line);
        far_end.line[far_end.length] = text[i];
        ++far_end.length;
        if ((text[i] == '\r') || (text[i] == '\a')) {
            take_line();
            far_end.length = 0;
        }
    }
    return (ssize_t)written;
}

int LLVMFuzzerTestOneInput(const uint8_t *const data, const size_t size) {
    memset(&far_end, 0, sizeof far_end);
    far_end.input.at = data;
    far_end.input.left = size;
    far_end.slcan.open = true;
    port.in = 7;
    port.out = 8;
    port.ended = false;
    port.pending = false;
    port.slow = 1;
    port.read_us = 0;
    port.input.begin = port.input.end = 0;
    port.output.begin = port.output.end = 0;
    CHECK(port_node_init(&port.node) == CCGEN_OK);
    CHECK(ccgen_slcan_init(&port.slcan) == CCGEN_OK);
    const line_t line = run(&port);
    CHECK(far_end.failed || (line == LINE_ENDED));
    CHECK(far_end.failed || ((far_end.answered == far_end.asked) && (far_end.length == 0u)));
    return 0;
}
