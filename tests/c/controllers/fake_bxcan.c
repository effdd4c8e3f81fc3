/**
 * \file fake_bxcan.c
 * \brief A model of bxCAN's registers, as RM0008 and RM0090 describe them, and of a board with it.
 *
 * What the manual forbids ends the program as wrong: bit timing outside of the initialisation mode,
 * filters outside of theirs, a mailbox that is not empty, an empty FIFO.
 */
#include <stdlib.h>
#include <string.h>

#include "board.h"
#include "bus.h"
#include "must.h"

enum { MCR, MSR, TSR, RF0R, RF1R, IER, ESR, BTR };

#define TX 0x60u /* words: mailboxes from 0x180, four words each */
#define RX 0x6Cu
#define FMR 0x80u
#define FM1R 0x81u
#define FS1R 0x83u
#define FFA1R 0x85u
#define FA1R 0x87u
#define FR 0x90u
#define WORDS 0x100u

#define RECOVERY 15u /* steps: 128 times 11 bits at 1 Mbit/s */

volatile uint32_t fake_block[WORDS];

static struct {
    uint32_t word[WORDS];
    uint32_t fifo[3][4];
    uint32_t waiting; /* frames in the FIFO */
    bool overrun;
    bool sends[3];
    bool aborts[3];
    uint32_t order[3]; /* when a mailbox was filled */
    uint32_t filled;
    uint32_t tec;
    bool off;
    uint32_t recovering; /* steps left */
    uint32_t asked;      /* reads until the mode changes */
    uint32_t reads;      /* for interrupts in between */
    bool releasing;
    bool inside; /* the interrupt */
} bx = {.word = {[MCR] = 0x10002u, [MSR] = 0x2u, [TSR] = 0x1C000000u, [FMR] = 1u}};

static bool in_init(void) {
    return (bx.word[MSR] & 1u) != 0u;
}

static bool on_bus(void) {
    return ((bx.word[MSR] & 3u) == 0u) && !bx.off;
}

static void interrupt(void) {
    const bool asked = (bx.waiting > 0u) && ((bx.word[IER] & 2u) != 0u);
    if (!bx.inside && asked && !bus_within("FAKE_DEAF")) {
        bx.inside = true;
        board_can_interrupt();
        bx.inside = false;
    }
}

static void change_mode(void) {
    const uint32_t was = bx.word[MSR];
    bx.word[MSR] = (was & ~3u) | (bx.word[MCR] & 3u);
    if (((was & 1u) != 0u) && !in_init() && bx.off) {
        bx.recovering = RECOVERY;
    }
}

/** A mode comes some time after it was asked for. */
static void approach_mode(void) {
    if ((bx.asked > 0u) && (--bx.asked == 0u)) {
        change_mode();
    }
}

uint32_t fake_read(volatile uint32_t *const address) {
    const uint32_t at = (uint32_t)(address - fake_block);
    CHECK(at < WORDS);
    if (at == MSR) {
        approach_mode();
    }
    if (at == RF0R) {
        const uint32_t value = bx.waiting | ((bx.waiting == 3u) ? 8u : 0u) |
                               (bx.overrun ? 16u : 0u) | (bx.releasing ? 32u : 0u);
        bx.releasing = false;
        bx.reads += 1u;
        if (bx.reads % 3u == 0u) {
            interrupt(); /* it comes when it likes */
        }
        return value;
    }
    if (at == ESR) {
        return (bx.word[ESR] & 0x70u) | (bx.off ? 4u : 0u) |
               ((bx.tec > 255u ? 255u : bx.tec) << 16);
    }
    if ((at >= RX) && (at < RX + 4u)) {
        CHECK(bx.waiting > 0u);
        return bx.fifo[0][at - RX];
    }
    return bx.word[at];
}

static void release(void) {
    CHECK(bx.waiting > 0u);
    bx.waiting -= 1u;
    memmove(bx.fifo[0], bx.fifo[1], sizeof bx.fifo[0] * 2u);
    bx.releasing = true;
}

static void write_tsr(const uint32_t value) {
    for (uint32_t i = 0; i < 3u; ++i) {
        if ((value & (1u << (8u * i))) != 0u) {
            bx.word[TSR] &= ~(0xFu << (8u * i));
        }
        if (((value & (0x80u << (8u * i))) != 0u) && bx.sends[i]) {
            bx.aborts[i] = true;
        }
    }
}

static void request(const uint32_t i) {
    CHECK((bx.word[TSR] & (1u << (26u + i))) != 0u);
    bx.word[TSR] &= ~((1u << (26u + i)) | (0xFu << (8u * i)));
    bx.sends[i] = true;
    bx.order[i] = bx.filled;
    bx.filled += 1u;
}

void fake_write(volatile uint32_t *const address, const uint32_t value) {
    const uint32_t at = (uint32_t)(address - fake_block);
    CHECK(at < WORDS);
    if (at == TSR) {
        write_tsr(value);
        return;
    }
    if (at == RF0R) {
        bx.overrun = bx.overrun && ((value & 16u) == 0u);
        if ((value & 32u) != 0u) {
            release();
        }
        return;
    }
    CHECK((at != BTR) || in_init());
    CHECK(at != MSR);
    if (((at >= FM1R) && (at <= FFA1R)) || (at >= FR)) {
        CHECK((bx.word[FMR] & 1u) != 0u);
    }
    if ((at >= TX) && (at < RX)) {
        const uint32_t i = (at - TX) / 4u;
        CHECK(!bx.sends[i]); /* it is write-protected then */
        bx.word[at] = value;
        if (((at - TX) % 4u == 0u) && ((value & 1u) != 0u)) {
            request(i);
        }
        return;
    }
    bx.word[at] = value;
    if (at == MCR) {
        bx.asked = 3u;
    }
}

static bool accepted(const uint32_t header) {
    for (uint32_t i = 0; i < 28u; ++i) {
        const bool active = ((bx.word[FA1R] >> i) & 1u) != 0u;
        CHECK(!active || (((bx.word[FS1R] & ~bx.word[FM1R] & ~bx.word[FFA1R]) >> i) & 1u) != 0u);
        if (active && (((header ^ bx.word[FR + 2u * i]) & bx.word[FR + 2u * i + 1u]) == 0u)) {
            return true;
        }
    }
    return false;
}

static uint32_t word_of(const uint8_t *const data) {
    return (uint32_t)data[0] | ((uint32_t)data[1] << 8) | ((uint32_t)data[2] << 16) |
           ((uint32_t)data[3] << 24);
}

static void hear(const bus_frame_t *const frame) {
    const bool extended = (frame->flags & BUS_EXTENDED) != 0u;
    const uint32_t header = (extended ? (frame->id << 3) | 4u : frame->id << 21) |
                            (((frame->flags & BUS_REMOTE) != 0u) ? 2u : 0u);
    if (((frame->flags & BUS_FD) != 0u) || !on_bus() || ((bx.word[FMR] & 1u) != 0u) ||
        !accepted(header)) {
        return;
    }
    if (bx.waiting == 3u) {
        CHECK((bx.word[MCR] & 8u) != 0u); /* what is older stays */
        bx.overrun = true;
        return;
    }
    uint32_t *const to = bx.fifo[bx.waiting];
    to[0] = header;
    to[1] = frame->dlc;
    to[2] = word_of(&frame->data[0]);
    to[3] = word_of(&frame->data[4]);
    bx.waiting += 1u;
}

static void finish(const uint32_t i, const bool sent) {
    bx.sends[i] = false;
    bx.aborts[i] = false;
    bx.word[TX + 4u * i] &= ~1u;
    bx.word[TSR] |= (1u << (26u + i)) | ((sent ? 3u : 1u) << (8u * i));
}

/** The mailbox that is next, by order of filling with TXFP, else by identifier; 3: none. */
static uint32_t chosen(void) {
    const bool by_order = (bx.word[MCR] & 4u) != 0u;
    uint32_t best = 3u;
    for (uint32_t i = 0; i < 3u; ++i) {
        const bool first = (best == 3u) || (by_order ? bx.order[i] < bx.order[best]
                                                     : bx.word[TX + 4u * i] < bx.word[TX + 4u * best]);
        if (bx.sends[i] && first) {
            best = i;
        }
    }
    return best;
}

static bus_result_t put_on_bus(const uint32_t i) {
    bus_frame_t frame = {0};
    const uint32_t *const from = &bx.word[TX + 4u * i];
    const bool extended = (from[0] & 4u) != 0u;
    frame.id = extended ? from[0] >> 3 : from[0] >> 21;
    frame.flags = (uint8_t)((extended ? BUS_EXTENDED : 0) | (((from[0] & 2u) != 0u) ? 2 : 0));
    frame.dlc = (uint8_t)(from[1] & 15u);
    for (uint32_t k = 0; k < 8u; ++k) {
        frame.data[k] = (uint8_t)(from[2u + k / 4u] >> (8u * (k % 4u)));
    }
    return bus_send(&frame);
}

static void send(void) {
    const uint32_t next = chosen();
    if (next == 3u) {
        return;
    }
    const bus_result_t result = put_on_bus(next);
    if (result == BUS_SENT) {
        bx.tec -= (bx.tec > 0u) ? 1u : 0u;
        finish(next, true);
    } else if (result == BUS_DESTROYED || bx.tec < 128u) {
        bx.tec += 8u;
    }
    if (result != BUS_SENT) {
        bx.word[ESR] = (bx.word[ESR] & ~0x70u) | ((result == BUS_ALONE) ? 0x30u : 0x50u);
    }
    bx.off = bx.tec > 255u;
}

void fake_step(void) {
    bus_frame_t frame;
    approach_mode();
    if (bus_next(&frame)) {
        hear(&frame);
    } else if (on_bus()) {
        send();
    }
    for (uint32_t i = 0; i < 3u; ++i) {
        if (bx.aborts[i] && bx.sends[i]) {
            finish(i, false);
        }
    }
    if ((bx.recovering > 0u) && !bus_within("FAKE_OFF") && (--bx.recovering == 0u)) {
        bx.off = false;
        bx.tec = 0u;
    }
    interrupt();
}

int board_can_start(board_can_t *const can, const can_port_config_t *const config) {
    can_port_config_t own = *config;
    bus_counters = &can->counters;
    own.clock_hz = 42000000u;
    const int result = can_bxcan_start(can, fake_block, &own);
    CHECK((result != CAN_PORT_OK) || ((bx.word[BTR] & 0x3FFu) < 42u));
    return result;
}
