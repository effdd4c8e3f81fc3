/**
 * \file fake_fdcan.c
 * \brief A model of FDCAN's registers and message RAM, as RM0440 describes them, and of a board
 * with it.
 *
 * What the manual forbids ends the program as wrong: settings while CCCR does not allow changes, a
 * buffer that is pending, a FIFO's place that is not the oldest.
 */
#include <stdlib.h>
#include <string.h>

#include "board.h"
#include "bus.h"
#include "must.h"

#define AT(offset) ((offset) / 4u)
#define DBTP AT(0x0Cu)
#define CCCR AT(0x18u)
#define NBTP AT(0x1Cu)
#define PSR AT(0x44u)
#define TDCR AT(0x48u)
#define IR AT(0x50u)
#define IE AT(0x54u)
#define ILE AT(0x5Cu)
#define RXGFC AT(0x80u)
#define RXF0S AT(0x90u)
#define RXF0A AT(0x94u)
#define TXBC AT(0xC0u)
#define TXFQS AT(0xC4u)
#define TXBRP AT(0xC8u)
#define TXBAR AT(0xCCu)
#define TXBCR AT(0xD0u)
#define TXBTO AT(0xD4u)
#define TXBCF AT(0xD8u)
#define WORDS 0x41u
#define RAM_WORDS 212u

#define RECOVERY 15u /* steps: 129 times 11 bits at 1 Mbit/s */

volatile uint32_t fake_block[WORDS];
volatile uint32_t fake_memory[RAM_WORDS];

static struct {
    uint32_t word[WORDS];
    uint32_t memory[RAM_WORDS];
    uint32_t waiting; /* frames in FIFO 0 */
    uint32_t oldest;
    uint32_t put; /* where the next frame to send goes */
    uint32_t next; /* and which goes next */
    uint32_t tec;
    uint32_t recovering; /* steps left; 0: not in bus-off, or INIT is set */
    uint32_t reads;      /* for interrupts in between */
    bool inside;         /* the interrupt */
} fd = {.word = {[CCCR] = 1u, [NBTP] = 0x06000A03u, [DBTP] = 0xA33u, [PSR] = 0x707u}};

static bool may_change(void) {
    return (fd.word[CCCR] & 3u) == 3u;
}

static void interrupt(void) {
    const bool asked = (fd.word[IR] & fd.word[IE]) != 0u;
    if (!fd.inside && asked && ((fd.word[ILE] & 1u) != 0u) && !bus_within("FAKE_DEAF")) {
        fd.inside = true;
        board_can_interrupt();
        fd.inside = false;
    }
}

static uint32_t free_buffers(void) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < 3u; ++i) { /* consecutive, from the put index on */
        if (((fd.word[TXBRP] >> ((fd.put + i) % 3u)) & 1u) != 0u) {
            break;
        }
        ++count;
    }
    return count;
}

static uint32_t read_register(const uint32_t at) {
    uint32_t value = fd.word[at];
    if (at == RXF0S) {
        value = fd.waiting | (fd.oldest << 8) | ((fd.waiting == 3u) ? 1u << 24 : 0u);
    } else if (at == TXFQS) {
        value = free_buffers() | (fd.next << 8) | (fd.put << 16) |
                ((free_buffers() == 0u) ? 1u << 21 : 0u);
    } else if (at == PSR) {
        fd.word[PSR] |= 0x707u; /* no error since */
    }
    return value;
}

uint32_t fake_read(volatile uint32_t *const address) {
    if ((address >= fake_memory) && (address < fake_memory + RAM_WORDS)) {
        return fd.memory[address - fake_memory];
    }
    const uint32_t at = (uint32_t)(address - fake_block);
    CHECK(at < WORDS);
    const uint32_t value = read_register(at);
    fd.reads += 1u;
    if ((at == RXF0S) && (fd.reads % 3u == 0u)) {
        interrupt(); /* it comes when it likes */
    }
    return value;
}

static void write_cccr(const uint32_t value) {
    const uint32_t was = fd.word[CCCR];
    CHECK(((was & 3u) == 3u) || (((value ^ was) & 0x300u) == 0u)); /* FDOE, BRSE */
    CHECK(((value & 2u) == 0u) || ((was & 1u) != 0u));
    fd.word[CCCR] = ((value & 1u) != 0u) ? value : (value & ~2u);
    if (may_change()) { /* resets what goes on */
        fd.word[TXBRP] = fd.word[TXBTO] = fd.word[TXBCF] = 0u;
        fd.waiting = fd.oldest = fd.put = fd.next = 0u;
    }
    if (((was & 1u) != 0u) && ((value & 1u) == 0u) && ((fd.word[PSR] & 0x80u) != 0u)) {
        fd.recovering = RECOVERY;
    }
}

static void request(const uint32_t buffers) {
    for (uint32_t i = 0; i < 3u; ++i) {
        if (((buffers >> i) & 1u) != 0u) {
            CHECK((((fd.word[TXBRP] >> i) & 1u) == 0u) && (i == fd.put));
            CHECK((fd.word[CCCR] & 1u) == 0u);
            fd.word[TXBRP] |= 1u << i;
            fd.word[TXBTO] &= ~(1u << i);
            fd.word[TXBCF] &= ~(1u << i);
            fd.put = (fd.put + 1u) % 3u;
        }
    }
}

void fake_write(volatile uint32_t *const address, const uint32_t value) {
    if ((address >= fake_memory) && (address < fake_memory + RAM_WORDS)) {
        const uint32_t word = (uint32_t)(address - fake_memory);
        CHECK((word < 158u) ? may_change()
                            : ((fd.word[TXBRP] >> ((word - 158u) / 18u)) & 1u) == 0u);
        fd.memory[word] = value;
        return;
    }
    const uint32_t at = (uint32_t)(address - fake_block);
    CHECK(at < WORDS);
    if (at == CCCR) {
        write_cccr(value);
    } else if (at == IR) {
        fd.word[IR] &= ~value;
    } else if (at == RXF0A) {
        CHECK((fd.waiting > 0u) && (value == fd.oldest));
        fd.waiting -= 1u;
        fd.oldest = (fd.oldest + 1u) % 3u;
    } else if (at == TXBAR) {
        request(value);
    } else if (at == TXBCR) {
        fd.word[TXBCR] |= value & fd.word[TXBRP];
    } else {
        CHECK((at == IE) || (at == ILE) || (at == AT(0x58u)) || may_change());
        CHECK((at != RXGFC) || (((value >> 16) & 31u) <= 28u && ((value >> 24) & 15u) <= 8u));
        fd.word[at] = value;
    }
}

static bool accepted(const bus_frame_t *const frame) {
    const bool extended = (frame->flags & BUS_EXTENDED) != 0u;
    const uint32_t settings = fd.word[RXGFC];
    if (((frame->flags & BUS_REMOTE) != 0u) && ((settings & (extended ? 1u : 2u)) != 0u)) {
        return false;
    }
    const uint32_t count = (settings >> (extended ? 24 : 16)) & (extended ? 15u : 31u);
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t first = fd.memory[extended ? 28u + 2u * i : i];
        const uint32_t second = extended ? fd.memory[29u + 2u * i] : first;
        CHECK((second >> 30) == 2u); /* a filter and its mask */
        CHECK(((extended ? first >> 29 : first >> 27) & 7u) == 1u); /* into FIFO 0 */
        const uint32_t id = extended ? first & 0x1FFFFFFFu : (first >> 16) & 0x7FFu;
        const uint32_t mask = extended ? second & 0x1FFFFFFFu : second & 0x7FFu;
        if (((frame->id ^ id) & mask) == 0u) {
            return true;
        }
    }
    CHECK(((settings >> (extended ? 2 : 4)) & 2u) != 0u); /* what passes none is rejected */
    return false;
}

static void hear(const bus_frame_t *const frame) {
    const bool extended = (frame->flags & BUS_EXTENDED) != 0u;
    const bool flexible = (frame->flags & BUS_FD) != 0u;
    if (((fd.word[CCCR] & 1u) != 0u) || (flexible && ((fd.word[CCCR] & 0x100u) == 0u)) ||
        !accepted(frame)) {
        return;
    }
    if (fd.waiting == 3u) {
        fd.word[IR] |= 4u;
        return;
    }
    uint32_t *const to = &fd.memory[44u + 18u * ((fd.oldest + fd.waiting) % 3u)];
    to[0] = (extended ? frame->id | (1u << 30) : frame->id << 18) |
            (((frame->flags & BUS_REMOTE) != 0u) ? 1u << 29 : 0u);
    to[1] = ((uint32_t)frame->dlc << 16) | (flexible ? 1u << 21 : 0u) |
            (((frame->flags & BUS_SWITCH) != 0u) ? 1u << 20 : 0u);
    for (uint32_t i = 0; i < 64u; ++i) {
        to[2u + i / 4u] &= ~(0xFFu << (8u * (i % 4u)));
        to[2u + i / 4u] |= (uint32_t)frame->data[i] << (8u * (i % 4u));
    }
    fd.waiting += 1u;
    fd.word[IR] |= 1u;
}

static bus_result_t put_on_bus(void) {
    const uint32_t *const from = &fd.memory[158u + 18u * fd.next];
    bus_frame_t frame = {0};
    const bool extended = (from[0] >> 30 & 1u) != 0u;
    const bool flexible = (from[1] >> 21 & 1u) != 0u;
    const bool fast = (from[1] >> 20 & 1u) != 0u;
    frame.id = extended ? from[0] & 0x1FFFFFFFu : (from[0] >> 18) & 0x7FFu;
    frame.dlc = (uint8_t)((from[1] >> 16) & 15u);
    CHECK(!flexible || ((fd.word[CCCR] & 0x100u) != 0u));
    CHECK(!fast || ((fd.word[CCCR] & 0x200u) != 0u));
    frame.flags = (uint8_t)((extended ? BUS_EXTENDED : 0) | (flexible ? BUS_FD : 0) |
                            (fast ? BUS_SWITCH : 0));
    for (uint32_t i = 0; i < 64u; ++i) {
        frame.data[i] = (uint8_t)(from[2u + i / 4u] >> (8u * (i % 4u)));
    }
    return bus_send(&frame);
}

/** The FIFO's get index goes on to the next buffer that is pending. */
static void advance(void) {
    for (uint32_t i = 0; (i < 3u) && (((fd.word[TXBRP] >> fd.next) & 1u) == 0u); ++i) {
        fd.next = (fd.next + 1u) % 3u;
    }
    if (fd.word[TXBRP] == 0u) {
        fd.next = fd.put;
    }
}

static void note_error(const uint32_t code) {
    fd.word[PSR] = (fd.word[PSR] & ~7u) | code;
}

static void send(void) {
    if (((fd.word[TXBRP] >> fd.next) & 1u) == 0u) {
        return;
    }
    const bus_result_t result = put_on_bus();
    if (result == BUS_SENT) {
        fd.tec -= (fd.tec > 0u) ? 1u : 0u;
        fd.word[TXBRP] &= ~(1u << fd.next);
        fd.word[TXBTO] |= 1u << fd.next;
        fd.word[TXBCR] &= ~(1u << fd.next);
        note_error(0u);
    } else {
        fd.tec += ((result == BUS_DESTROYED) || (fd.tec < 128u)) ? 8u : 0u;
        note_error((result == BUS_ALONE) ? 3u : 5u);
    }
    if (fd.tec > 255u) {
        fd.word[PSR] |= 0x80u;
        fd.word[CCCR] |= 1u;
    }
}

static void cancel(void) {
    const uint32_t given_up = fd.word[TXBCR] & fd.word[TXBRP];
    fd.word[TXBRP] &= ~given_up;
    fd.word[TXBCF] |= given_up;
    fd.word[TXBCR] = 0u;
    advance();
}

void fake_step(void) {
    bus_frame_t frame;
    if (bus_next(&frame)) {
        hear(&frame);
    } else if (((fd.word[CCCR] & 1u) == 0u) && (fd.recovering == 0u)) {
        send();
    }
    cancel();
    if ((fd.recovering > 0u) && !bus_within("FAKE_OFF") && (--fd.recovering == 0u)) {
        fd.word[PSR] &= ~0x80u;
        fd.tec = 0u;
    }
    interrupt();
}

int board_can_start(board_can_t *const can, const can_port_config_t *const config) {
    can_port_config_t own = *config;
    bus_counters = &can->counters;
    own.clock_hz = 80000000u;
    const int result = can_fdcan_start(can, fake_block, fake_memory, &own);
    CHECK((result != CAN_PORT_OK) || (config->fd == ((fd.word[CCCR] & 0x100u) != 0u)));
    return result;
}
