/**
 * \file can_mcp2515.c
 * \brief See can_mcp2515.h. Names are the data sheet's.
 */
#include "can_mcp2515.h"

#include <string.h>

#include "can_timing.h"

CCGEN_STATIC_ASSERT((CAN_MCP2515_DEPARTURES >= 1) && (CAN_MCP2515_DEPARTURES <= 128) &&
                        ((CAN_MCP2515_DEPARTURES & (CAN_MCP2515_DEPARTURES - 1)) == 0),
                    can_mcp2515_departures_are_a_power_of_two);

/* Instructions. */
#define DO_WRITE 0x02u
#define DO_READ 0x03u
#define DO_MODIFY 0x05u
#define DO_LOAD_TX0 0x40u
#define DO_SEND_TX0 0x81u
#define DO_READ_RX0 0x90u
#define DO_READ_RX1 0x94u
#define DO_RESET 0xC0u

/* Registers. */
#define RXF0SIDH 0x00u
#define RXF3SIDH 0x10u
#define RXM0SIDH 0x20u
#define CNF3 0x28u    /* then CNF2, CNF1, CANINTE */
#define CANINTF 0x2Cu /* then EFLG, CANSTAT, CANCTRL */
#define EFLG 0x2Du
#define CANCTRL 0x2Fu
#define TXB0CTRL 0x30u
#define RXB0CTRL 0x60u

/* Their bits. */
#define RX0IF 0x01u
#define RX1IF 0x02u
#define TX0IF 0x04u
#define MERRF 0x80u
#define TXBO 0x20u
#define RX0OVR 0x40u
#define RX1OVR 0x80u
#define ABTF 0x40u
#define TXREQ 0x08u
#define BUKT 0x04u
#define BTLMODE 0x80u
#define OPMOD 0xE0u
#define OPMOD_CONFIGURATION 0x80u
#define EXIDE 0x08u
#define SRR 0x10u
#define RTR 0x40u

/** Normal mode, CLKOUT as after a reset: unlike 0 and 0xFF, as which a dead line reads. */
#define CANCTRL_NORMAL 0x07u
/** What pulls INT. Errors are looked for: in error-passive ERRIF would hold INT down. */
#define CANINTE_FRAMES (RX0IF | RX1IF | TX0IF)

#define CLOCK_MAX 40000000u
#define LOOK_US 1000u /* how often the chip is asked though INT is high */
#define ROUNDS 8u     /* of one call, at most */
/** Looks at a chip until it counts as silent: it wakes within 128 periods of its clock. */
#define PATIENCE 250u

/* What the chip tells in one read. */
typedef struct {
    uint8_t flags, errors, status, control;
} look_t;

/* Speaking with the chip. */

static void exchange(const can_mcp2515_t *const can, uint8_t *const bytes, const uint8_t number) {
    can->board->exchange(can->board->context, bytes, number);
}

static void instruct(const can_mcp2515_t *const can, const uint8_t instruction) {
    uint8_t bytes[1];
    bytes[0] = instruction;
    exchange(can, bytes, 1);
}

static void clear_bits(const can_mcp2515_t *const can, const uint8_t address, const uint8_t bits) {
    uint8_t bytes[4] = {DO_MODIFY, 0, 0, 0};
    bytes[1] = address;
    bytes[2] = bits;
    exchange(can, bytes, 4);
}

/** Writes registers in a row, 12 at most. */
static void put(const can_mcp2515_t *const can, const uint8_t address, const uint8_t *const values,
                const uint8_t number) {
    uint8_t bytes[CAN_MCP2515_EXCHANGE_MAX];
    bytes[0] = DO_WRITE;
    bytes[1] = address;
    memcpy(&bytes[2], values, number);
    exchange(can, bytes, (uint8_t)(2u + number));
}

static void put_one(const can_mcp2515_t *const can, const uint8_t address, const uint8_t value) {
    put(can, address, &value, 1);
}

/** Reads registers in a row, 4 at most. */
static void get(const can_mcp2515_t *const can, const uint8_t address, uint8_t *const values,
                const uint8_t number) {
    uint8_t bytes[6] = {DO_READ, 0, 0, 0, 0, 0};
    bytes[1] = address;
    exchange(can, bytes, (uint8_t)(2u + number));
    memcpy(values, &bytes[2], number);
}

static look_t look(const can_mcp2515_t *const can) {
    uint8_t values[4];
    look_t seen;
    get(can, CANINTF, values, 4);
    seen.flags = values[0];
    seen.errors = values[1];
    seen.status = values[2];
    seen.control = values[3];
    return seen;
}

/* Identifiers and frames as the chip's registers have them. */

/** SIDH, SIDL, EID8, EID0. */
static void put_id(uint8_t *const bytes, const uint32_t id, const bool extended) {
    const uint32_t standard = extended ? (id >> 18) : id;
    bytes[0] = (uint8_t)((standard >> 3) & 0xFFu);
    bytes[1] = (uint8_t)((standard & 7u) << 5);
    bytes[2] = 0;
    bytes[3] = 0;
    if (extended) {
        bytes[1] = (uint8_t)(bytes[1] | EXIDE | ((id >> 16) & 3u));
        bytes[2] = (uint8_t)((id >> 8) & 0xFFu);
        bytes[3] = (uint8_t)(id & 0xFFu);
    }
}

static void put_frame(volatile uint8_t *const to, const ccgen_frame_t *const frame) {
    uint8_t id[4];
    put_id(id, frame->id, frame->extended);
    for (uint8_t i = 0; i < 4u; ++i) {
        to[i] = id[i];
    }
    to[4] = (uint8_t)(frame->length | (frame->remote ? RTR : 0u));
    for (uint8_t i = 0; i < 8u; ++i) {
        to[5u + i] = (i < frame->length) ? frame->data[i] : 0u;
    }
}

static void get_frame(const uint8_t *const from, ccgen_frame_t *const frame) {
    const uint8_t length = (uint8_t)(from[4] & 0x0Fu);
    const uint32_t standard = ((uint32_t)from[0] << 3) | ((uint32_t)from[1] >> 5);
    frame->extended = (from[1] & EXIDE) != 0u;
    frame->id = standard;
    if (frame->extended) {
        frame->id = (standard << 18) | (((uint32_t)from[1] & 3u) << 16) |
                    ((uint32_t)from[2] << 8) | (uint32_t)from[3];
    }
    frame->fd = false;
    frame->rate_switch = false;
    frame->remote = frame->extended ? ((from[4] & RTR) != 0u) : ((from[1] & SRR) != 0u);
    frame->length = (length > 8u) ? 8u : length; /* ISO 11898-1: 9 to 15 mean 8 */
    memcpy(frame->data, &from[5], 8);
}

/* Setting up. */

/** \return whether the crystal gives exactly the bit rate; then CNF3, CNF2 and CNF1 */
static bool find_timing(const can_port_config_t *const config, uint8_t *const cnf) {
    static const can_timing_limits_t limits = {64u, 2u, 16u, 2u, 8u, 4u};
    can_timing_t timing;
    if (((config->clock_hz % 2u) != 0u) || (config->clock_hz > CLOCK_MAX) ||
        (config->bitrate > 1000000u) ||
        !can_timing_find(config->clock_hz / 2u, config->bitrate, &limits, &timing)) {
        return false;
    }
    const uint16_t phase = (uint16_t)(timing.segment1 / 2u);
    const uint16_t propagation = (uint16_t)(timing.segment1 - phase);
    const uint16_t jump =
        (timing.jump < timing.segment2) ? timing.jump : (uint16_t)(timing.segment2 - 1u);
    cnf[0] = (uint8_t)(timing.segment2 - 1u);
    cnf[1] = (uint8_t)(BTLMODE | ((phase - 1u) << 3) | (propagation - 1u));
    cnf[2] = (uint8_t)(((jump - 1u) << 6) | (timing.prescaler - 1u));
    return true;
}

/** \return whether the filters are six, with a mask for the first two and one for the rest */
static bool put_filters(const can_port_config_t *const config, uint8_t *const settings) {
    const can_port_filter_t *const filters = config->filters;
    if (config->filter_count != CAN_MCP2515_FILTERS) {
        return false;
    }
    for (uint8_t i = 0; i < CAN_MCP2515_FILTERS; ++i) {
        if (filters[i].mask != filters[(i < 2u) ? 0u : 2u].mask) {
            return false;
        }
        put_id(&settings[(size_t)4u * i], filters[i].id, config->extended);
    }
    put_id(&settings[24], filters[0].mask, config->extended);
    put_id(&settings[28], filters[2].mask, config->extended);
    return true;
}

/** Gives its settings to a chip that was reset. \return whether it has taken them */
static bool set_up(const can_mcp2515_t *const can) {
    uint8_t found[4];
    if ((look(can).status & OPMOD) != OPMOD_CONFIGURATION) {
        return false;
    }
    put(can, RXF0SIDH, &can->settings[0], 12);
    put(can, RXF3SIDH, &can->settings[12], 12);
    put(can, RXM0SIDH, &can->settings[24], 12);
    get(can, CNF3, found, 4);
    if (memcmp(found, &can->settings[32], 4) != 0) {
        return false;
    }
    put_one(can, RXB0CTRL, BUKT);
    put_one(can, CANCTRL, CANCTRL_NORMAL);
    return true;
}

/* Sending. */

static void count(volatile uint32_t *const counter, const uint8_t number) {
    *counter = *counter + number;
}

/** \return whether a time lies more than a cycle back; one ahead is as good as now */
static bool is_old(const can_mcp2515_t *const can, const uint32_t at_us, const uint32_t now_us) {
    const uint32_t age_us = now_us - at_us;
    return (age_us > can->cycle_us) && (age_us < 0x80000000u);
}

/** Asks for the buffer back. A frame that is on the bus by then goes on to its end. */
static void abort_loaded(can_mcp2515_t *const can) {
    if (can->loaded && !can->aborting) {
        can->aborting = true;
        clear_bits(can, TXB0CTRL, TXREQ);
    }
}

/** Gives up what waits before the buffer. */
static void forget_departures(can_mcp2515_t *const can) {
    const uint8_t head = can->head;
    count(&can->counters.aborted, (uint8_t)(head - can->tail));
    can->tail = head;
}

/**
 * Takes note of a frame that has left the buffer, sent or not. One that was aborted says so, unless
 * it goes on to its end; that takes no cycle.
 */
static void settle(can_mcp2515_t *const can, const uint8_t flags, const uint32_t now_us) {
    uint8_t control;
    if ((flags & TX0IF) != 0u) {
        clear_bits(can, CANINTF, TX0IF);
        count(&can->counters.sent, 1);
        can->loaded = false;
    } else if (can->loaded && can->aborting) {
        get(can, TXB0CTRL, &control, 1);
        if (((control & TXREQ) == 0u) &&
            (((control & ABTF) != 0u) || is_old(can, can->handed_us + can->cycle_us, now_us))) {
            count(&can->counters.aborted, 1);
            can->loaded = false;
        }
    }
}

/** Loads the next frame that is young enough, where the buffer is free. */
static void load(can_mcp2515_t *const can, const uint32_t now_us) {
    while (!can->loaded && (can->tail != can->head)) {
        const uint8_t tail = can->tail;
        const volatile can_mcp2515_place_t *const next =
            &can->departures[tail % CAN_MCP2515_DEPARTURES];
        const uint32_t at_us = next->at_us;
        uint8_t bytes[CAN_MCP2515_EXCHANGE_MAX] = {DO_LOAD_TX0};
        for (size_t i = 0; i < sizeof next->bytes; ++i) {
            bytes[1u + i] = next->bytes[i];
        }
        can->tail = (uint8_t)(tail + 1u);
        if (is_old(can, at_us, now_us)) {
            count(&can->counters.aborted, 1);
        } else {
            exchange(can, bytes, sizeof bytes);
            instruct(can, DO_SEND_TX0);
            can->loaded = true;
            can->aborting = false;
            can->handed_us = at_us;
        }
    }
}

/* Receiving. */

static void fetch(can_mcp2515_t *const can, const uint8_t instruction, const uint32_t now_us) {
    ccgen_frame_t frame;
    uint8_t bytes[CAN_MCP2515_EXCHANGE_MAX] = {0};
    bytes[0] = instruction;
    exchange(can, bytes, sizeof bytes); /* which frees the buffer */
    get_frame(&bytes[1], &frame);
    can_port_arrived(&can->counters, &can->arrivals, &frame, now_us);
}

/**
 * Fetches what came in, oldest first. Buffer 1 fills while 0 is full, so that 0 holds the older
 * frame; but where 0 has just been read and both are full, 1 was full before that.
 */
static void fetch_all(can_mcp2515_t *const can, const uint8_t flags, const bool just_read,
                      const uint32_t now_us) {
    const bool reversed = just_read && ((flags & RX0IF) != 0u);
    if (reversed && ((flags & RX1IF) != 0u)) {
        fetch(can, DO_READ_RX1, now_us);
    }
    if ((flags & RX0IF) != 0u) {
        fetch(can, DO_READ_RX0, now_us);
    }
    if (!reversed && ((flags & RX1IF) != 0u)) {
        fetch(can, DO_READ_RX1, now_us);
    }
}

/* Errors. */

/** The chip has lost its settings: it is reset, and set up at one of the next looks. */
static void begin_anew(can_mcp2515_t *const can) {
    count(&can->counters.errors, 1);
    count(&can->counters.aborted, can->loaded ? 1u : 0u);
    forget_departures(can);
    can->loaded = false;
    can->running = false;
    instruct(can, DO_RESET);
}

static void see_errors(can_mcp2515_t *const can, const look_t *const seen) {
    const uint8_t overruns = (uint8_t)(seen->errors & (RX0OVR | RX1OVR));
    if (overruns != 0u) {
        count(&can->counters.dropped, 1);
        clear_bits(can, EFLG, overruns);
    }
    if ((seen->flags & MERRF) != 0u) {
        count(&can->counters.errors, 1);
        clear_bits(can, CANINTF, MERRF);
    }
    if ((seen->errors & TXBO) == 0u) {
        can->off = false;
    } else if (!can->off) {
        can->off = true;
        count(&can->counters.bus_off, 1);
    }
    if (can->off) {
        abort_loaded(can);
        forget_departures(can);
    }
}

/* Whose turn it is. */

/** \return flags that were set, of CANINTE_FRAMES: with one there may be more to do */
static uint8_t serve(can_mcp2515_t *const can, const bool just_read, const uint32_t now_us) {
    const look_t seen = look(can);
    if (seen.control != CANCTRL_NORMAL) {
        begin_anew(can);
        return 0;
    }
    fetch_all(can, seen.flags, just_read, now_us);
    settle(can, seen.flags, now_us);
    see_errors(can, &seen);
    load(can, now_us);
    return (uint8_t)(seen.flags & CANINTE_FRAMES);
}

static bool waits(const can_mcp2515_t *const can) {
    return (can->board->waits == NULL) || can->board->waits(can->board->context);
}

static void attend(can_mcp2515_t *const can, const uint32_t now_us) {
    const bool due = (now_us - can->looked_us) >= LOOK_US;
    if (due) {
        can->looked_us = now_us;
    }
    if (!can->running) {
        can->running = due && set_up(can);
        if (due && !can->running) {
            instruct(can, DO_RESET);
        }
        return;
    }
    if (can->loaded && is_old(can, can->handed_us, now_us)) {
        abort_loaded(can);
    }
    uint8_t flags = (due || waits(can)) ? serve(can, false, now_us) : 0u;
    for (uint8_t round = 1; (flags != 0u) && (round < ROUNDS); ++round) {
        flags = serve(can, (flags & RX0IF) != 0u, now_us);
    }
    load(can, now_us);
}

/** Attends to the chip, or leaves it to who does already. */
static void take_turn(can_mcp2515_t *const can, const uint32_t now_us) {
    if (can->busy || (can->board == NULL)) { /* or not started */
        can->missed = true;
        return;
    }
    can->busy = true;
    do {
        can->missed = false;
        attend(can, now_us);
    } while (can->missed);
    can->busy = false;
}

int can_mcp2515_start(can_mcp2515_t *const can, const can_mcp2515_board_t *const board,
                      const can_port_config_t *const config) {
    memset(can, 0, sizeof *can);
    can->busy = true; /* until all is well */
    can->board = board;
    can->cycle_us = config->cycle_us;
    if (config->fd) {
        return CAN_PORT_ERROR_FRAME;
    }
    if (!find_timing(config, &can->settings[32])) {
        return CAN_PORT_ERROR_TIMING;
    }
    if (!put_filters(config, can->settings)) {
        return CAN_PORT_ERROR_FILTERS;
    }
    can->settings[35] = CANINTE_FRAMES;
    instruct(can, DO_RESET);
    bool ready = false;
    for (uint8_t i = 0; !ready && (i < PATIENCE); ++i) {
        ready = set_up(can);
    }
    if (!ready || (look(can).control != CANCTRL_NORMAL)) {
        return CAN_PORT_ERROR_SILENT;
    }
    can->running = true;
    can->busy = false;
    return CAN_PORT_OK;
}

void can_mcp2515_receive(can_mcp2515_t *const can, const uint32_t now_us) {
    take_turn(can, now_us);
}

void can_mcp2515_service(can_mcp2515_t *const can, const uint32_t now_us) {
    take_turn(can, now_us);
}

int can_mcp2515_transmit(can_mcp2515_t *const can, const ccgen_frame_t *const frame,
                         const uint32_t now_us) {
    const uint8_t head = can->head;
    volatile can_mcp2515_place_t *const to = &can->departures[head % CAN_MCP2515_DEPARTURES];
    if (frame->fd || (frame->length > 8u)) {
        return CAN_PORT_ERROR_FRAME;
    }
    if (!can->running || can->off || ((uint8_t)(head - can->tail) == CAN_MCP2515_DEPARTURES)) {
        return 0;
    }
    to->at_us = now_us;
    put_frame(to->bytes, frame);
    can->head = (uint8_t)(head + 1u);
    take_turn(can, now_us);
    return 1;
}

void can_mcp2515_counters(can_mcp2515_t *const can, can_port_counters_t *const counters) {
    const bool busy = can->busy;
    can->busy = true;
    counters->received = can->counters.received;
    counters->dropped = can->counters.dropped;
    counters->sent = can->counters.sent;
    counters->aborted = can->counters.aborted;
    counters->bus_off = can->counters.bus_off;
    counters->errors = can->counters.errors;
    can->busy = busy;
}

void can_mcp2515_hold(can_mcp2515_t *const can) {
    can->busy = true;
}

void can_mcp2515_release(can_mcp2515_t *const can, const uint32_t now_us) {
    can->busy = false;
    take_turn(can, now_us);
}
