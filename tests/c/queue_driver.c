/**
 * \file queue_driver.c
 * \brief A queue of frames between a signal, which interrupts at any instruction, and a main loop.
 *
 *     queue_driver FRAMES
 *
 * Status 0: so many frames came out whole and in the order in which they went in.
 */
#define _POSIX_C_SOURCE 200809L

#include <signal.h>
#include <string.h>
#include <sys/time.h>

#include "ccgen/queue.h"
#include "must.h"

static ccgen_queue_t queue;   /* zero: empty */
static volatile uint32_t put; /* frames so far; the signal's alone */

/** A frame that its number determines in every byte. */
static ccgen_frame_t numbered(const uint32_t number) {
    ccgen_frame_t frame;
    memset(&frame, 0, sizeof frame);
    frame.id = number;
    frame.extended = (number % 2u) == 0u;
    frame.fd = (number % 3u) == 0u;
    frame.remote = (number % 5u) == 0u;
    frame.rate_switch = (number % 7u) == 0u;
    frame.length = (uint8_t)(number % (CCGEN_FRAME_CAPACITY + 1u));
    memset(frame.data, (int)(number % 251u), frame.length);
    return frame;
}

static void interrupt(const int number) {
    (void)number;
    for (uint32_t burst = 1u + put % 5u; burst > 0u; --burst) {
        const ccgen_frame_t frame = numbered(put);
        if (!ccgen_queue_put(&queue, &frame, ~put)) {
            return;
        }
        ++put;
    }
}

static void check(const uint32_t number) {
    const ccgen_frame_t expected = numbered(number);
    ccgen_frame_t frame;
    uint32_t at_us = 0;
    memset(&frame, 0, sizeof frame);
    while (!ccgen_queue_get(&queue, &frame, &at_us)) {
    }
    CHECK(at_us == (uint32_t)~number);
    CHECK((frame.id == expected.id) && (frame.extended == expected.extended));
    CHECK((frame.fd == expected.fd) && (frame.remote == expected.remote));
    CHECK((frame.rate_switch == expected.rate_switch) && (frame.length == expected.length));
    CHECK(memcmp(frame.data, expected.data, sizeof frame.data) == 0);
}

/** Fills the queue, finds it full, and empties it. */
static void check_ends(void) {
    ccgen_frame_t frame = numbered(0);
    uint32_t at_us = 1;
    CHECK(!ccgen_queue_get(&queue, &frame, &at_us) && (at_us == 1u));
    for (uint32_t round = 0; round < 300u; ++round) {
        for (uint32_t k = 0; k < CCGEN_QUEUE_PLACES; ++k) {
            frame = numbered(k);
            CHECK(ccgen_queue_put(&queue, &frame, ~k));
        }
        CHECK(!ccgen_queue_put(&queue, &frame, 0));
        for (uint32_t k = 0; k < CCGEN_QUEUE_PLACES; ++k) {
            check(k);
        }
        CHECK(!ccgen_queue_get(&queue, &frame, &at_us));
    }
    frame.length = CCGEN_FRAME_CAPACITY + 1u;
    CHECK(!ccgen_queue_put(&queue, &frame, 0));
}

int main(int argc, char *argv[]) {
    const struct itimerval often = {{0, 50}, {0, 50}};
    struct sigaction action;
    CHECK(argc == 2);
    const uint32_t frames = (uint32_t)strtoul(argv[1], NULL, 10);
    check_ends();
    memset(&action, 0, sizeof action);
    action.sa_handler = interrupt;
    CHECK(sigaction(SIGALRM, &action, NULL) == 0);
    CHECK(setitimer(ITIMER_REAL, &often, NULL) == 0);
    for (uint32_t number = 0; number < frames; ++number) {
        check(number);
    }
    return 0;
}
