/**
 * \file can_bxcan.c
 * \brief See can_bxcan.h. Names are the reference manual's.
 */
#include "can_bxcan.h"

#include "can_timing.h"

/* Offsets of registers, in bytes. */
#define MCR 0x000u
#define MSR 0x004u
#define TSR 0x008u
#define RF0R 0x00Cu
#define IER 0x014u
#define ESR 0x018u
#define BTR 0x01Cu
#define TIR(mailbox) (0x180u + (0x10u * (mailbox)))
#define TDTR(mailbox) (0x184u + (0x10u * (mailbox)))
#define TDLR(mailbox) (0x188u + (0x10u * (mailbox)))
#define TDHR(mailbox) (0x18Cu + (0x10u * (mailbox)))
#define RI0R 0x1B0u
#define RDT0R 0x1B4u
#define RDL0R 0x1B8u
#define RDH0R 0x1BCu
#define FMR 0x200u
#define FM1R 0x204u
#define FS1R 0x20Cu
#define FFA1R 0x214u
#define FA1R 0x21Cu
#define FR1(bank) (0x240u + (8u * (bank)))
#define FR2(bank) (0x244u + (8u * (bank)))

#define MCR_INRQ (1u << 0)
#define MCR_TXFP (1u << 2)
#define MCR_RFLM (1u << 3)
#define MSR_INAK (1u << 0)
#define MSR_SLAK (1u << 1)
#define TSR_RQCP(mailbox) (1u << (8u * (mailbox)))
#define TSR_TXOK(mailbox) (2u << (8u * (mailbox)))
#define TSR_ABRQ(mailbox) (0x80u << (8u * (mailbox)))
#define TSR_TME(mailbox) (1u << (26u + (mailbox)))
#define RF0R_FMP0 3u
#define RF0R_FOVR0 (1u << 4)
#define RF0R_RFOM0 (1u << 5)
#define IER_FMPIE0 (1u << 1)
#define ESR_BOFF (1u << 2)
#define ESR_LEC (7u << 4) /* written by software: none since */
#define TIR_TXRQ (1u << 0)
#define IR_RTR (1u << 1)
#define IR_IDE (1u << 2)
#define FMR_FINIT (1u << 0)

/** Reads of a flag until the controller counts as silent. */
#define PATIENCE 100000u
/** Frames that are read at once, so that a broken controller holds nobody up. */
#define AT_ONCE 16u

static uint32_t get(const can_bxcan_t *const can, const uint32_t offset) {
    return CAN_PORT_READ(&can->registers[offset / 4u]);
}

static void put(const can_bxcan_t *const can, const uint32_t offset, const uint32_t value) {
    CAN_PORT_WRITE(&can->registers[offset / 4u], value);
}

static uint32_t identifier_bits(const uint32_t id, const bool extended) {
    return extended ? ((id << 3) | IR_IDE) : (id << 21);
}

/** Lets own identifiers into FIFO 0: bank i holds filter i, of 32 bits with a mask. */
static void set_filters(const can_bxcan_t *const can, const can_port_config_t *const config) {
    const uint32_t banks = (1u << config->filter_count) - 1u;
    put(can, FMR, get(can, FMR) | FMR_FINIT);
    put(can, FA1R, 0u);
    put(can, FM1R, get(can, FM1R) & ~banks);
    put(can, FS1R, get(can, FS1R) | banks);
    put(can, FFA1R, get(can, FFA1R) & ~banks);
    for (uint32_t i = 0; i < config->filter_count; ++i) {
        const can_port_filter_t *const filter = &config->filters[i];
        put(can, FR1(i), identifier_bits(filter->id, config->extended));
        put(can, FR2(i), identifier_bits(filter->mask, config->extended) | IR_IDE | IR_RTR);
    }
    put(can, FA1R, banks);
    put(can, FMR, get(can, FMR) & ~FMR_FINIT);
}

/** Wakes the controller into its initialisation mode. */
static bool stop(const can_bxcan_t *const can) {
    put(can, MCR, MCR_INRQ);
    for (uint32_t i = 0; i < PATIENCE; ++i) {
        if ((get(can, MSR) & (MSR_INAK | MSR_SLAK)) == MSR_INAK) {
            return true;
        }
    }
    return false;
}

int can_bxcan_start(can_bxcan_t *const can, volatile uint32_t *const registers,
                    const can_port_config_t *const config) {
    static const can_timing_limits_t limits = {1024u, 1u, 16u, 1u, 8u, 4u};
    static const can_bxcan_t nothing; /* zero */
    can_timing_t timing;
    *can = nothing;
    can->registers = registers;
    can->cycle_us = config->cycle_us;
    if (config->fd) {
        return CAN_PORT_ERROR_FRAME;
    }
    if (!can_timing_find(config->clock_hz, config->bitrate, &limits, &timing)) {
        return CAN_PORT_ERROR_TIMING;
    }
    if (config->filter_count > CAN_BXCAN_FILTERS) {
        return CAN_PORT_ERROR_FILTERS;
    }
    if (!stop(can)) {
        return CAN_PORT_ERROR_SILENT;
    }
    put(can, BTR,
        ((timing.jump - 1u) << 24) | ((timing.segment2 - 1u) << 20) |
            ((timing.segment1 - 1u) << 16) | (timing.prescaler - 1u));
    set_filters(can, config);
    put(can, ESR, ESR_LEC);
    put(can, IER, IER_FMPIE0);
    put(can, MCR, MCR_TXFP | MCR_RFLM);
    return CAN_PORT_OK;
}

static void unpack(const uint32_t word, uint8_t *const data) {
    for (uint32_t i = 0; i < 4u; ++i) {
        data[i] = (uint8_t)(word >> (8u * i));
    }
}

static uint32_t packed(const uint8_t *const data) {
    return (uint32_t)data[0] | ((uint32_t)data[1] << 8) | ((uint32_t)data[2] << 16) |
           ((uint32_t)data[3] << 24);
}

/** Reads the oldest frame and gives its place back. */
static void read_frame(const can_bxcan_t *const can, ccgen_frame_t *const frame) {
    const uint32_t header = get(can, RI0R);
    const uint32_t length = get(can, RDT0R) & 0xFu;
    frame->extended = (header & IR_IDE) != 0u;
    frame->id = frame->extended ? header >> 3 : header >> 21;
    frame->fd = false;
    frame->remote = (header & IR_RTR) != 0u;
    frame->rate_switch = false;
    frame->length = (uint8_t)((length > 8u) ? 8u : length); /* ISO 11898-1: 9 to 15 mean 8 */
    unpack(get(can, RDL0R), &frame->data[0]);
    unpack(get(can, RDH0R), &frame->data[4]);
    put(can, RF0R, RF0R_RFOM0);
    for (uint32_t i = 0; (i < PATIENCE) && ((get(can, RF0R) & RF0R_RFOM0) != 0u); ++i) {
        /* a few clocks of the bus */
    }
}

static void read_all(can_bxcan_t *const can, const uint32_t now_us) {
    ccgen_frame_t frame;
    for (uint32_t i = 0; (i < AT_ONCE) && ((get(can, RF0R) & RF0R_FMP0) != 0u); ++i) {
        read_frame(can, &frame);
        can_port_arrived(&can->counters, &can->arrivals, &frame, now_us);
    }
    if ((get(can, RF0R) & RF0R_FOVR0) != 0u) {
        put(can, RF0R, RF0R_FOVR0);
        can->counters.dropped = can->counters.dropped + 1u;
    }
}

void can_bxcan_receive(can_bxcan_t *const can, const uint32_t now_us) {
    if (can->reading) {
        put(can, IER, 0u); /* service() lets it through again */
    } else {
        read_all(can, now_us);
    }
}

/** Counts what has left, or was given up, since. */
static void settle(can_bxcan_t *const can) {
    const uint32_t status = get(can, TSR);
    for (uint32_t i = 0; i < CAN_BXCAN_MAILBOXES; ++i) {
        if (can->pending[i] && ((status & TSR_RQCP(i)) != 0u)) {
            put(can, TSR, TSR_RQCP(i));
            can->pending[i] = false;
            if ((status & TSR_TXOK(i)) != 0u) {
                can->counters.sent += 1u;
            } else {
                can->counters.aborted += 1u;
            }
        }
    }
}

int can_bxcan_transmit(can_bxcan_t *const can, const ccgen_frame_t *const frame,
                       const uint32_t now_us) {
    if (frame->fd || (frame->length > 8u)) {
        return CAN_PORT_ERROR_FRAME;
    }
    settle(can);
    for (uint32_t i = 0; (i < CAN_BXCAN_MAILBOXES) && !can->off; ++i) {
        if (!can->pending[i] && ((get(can, TSR) & TSR_TME(i)) != 0u)) {
            const uint32_t header = identifier_bits(frame->id, frame->extended);
            put(can, TDTR(i), frame->length);
            put(can, TDLR(i), packed(&frame->data[0]));
            put(can, TDHR(i), packed(&frame->data[4]));
            put(can, TIR(i), header | (frame->remote ? IR_RTR : 0u) | TIR_TXRQ);
            can->pending[i] = true;
            can->handed_us[i] = now_us;
            return 1;
        }
    }
    return 0;
}

/** Aborts what has waited for longer than a cycle, or all. */
static void abort_old(const can_bxcan_t *const can, const uint32_t now_us, const bool all) {
    for (uint32_t i = 0; i < CAN_BXCAN_MAILBOXES; ++i) {
        if (can->pending[i] && (all || (now_us - can->handed_us[i] > can->cycle_us))) {
            put(can, TSR, TSR_ABRQ(i));
        }
    }
}

/**
 * Bus-off: into the initialisation mode and out of it, which begins the recovery. The controller
 * leaves bus-off by itself then.
 */
static void come_back(can_bxcan_t *const can) {
    const bool is_off = (get(can, ESR) & ESR_BOFF) != 0u;
    if (!can->off && is_off) {
        can->off = true;
        can->counters.bus_off += 1u;
        put(can, MCR, MCR_TXFP | MCR_RFLM | MCR_INRQ);
    } else if (can->off && ((get(can, MSR) & MSR_INAK) != 0u)) {
        put(can, MCR, MCR_TXFP | MCR_RFLM);
    } else if (!is_off) {
        can->off = false;
    }
}

static void count_errors(can_bxcan_t *const can) {
    const uint32_t code = get(can, ESR) & ESR_LEC;
    if ((code != 0u) && (code != ESR_LEC)) {
        can->counters.errors += 1u;
    }
    put(can, ESR, ESR_LEC);
}

void can_bxcan_service(can_bxcan_t *const can, const uint32_t now_us) {
    can->reading = true;
    read_all(can, now_us);
    can->reading = false;
    put(can, IER, IER_FMPIE0);
    count_errors(can);
    come_back(can);
    abort_old(can, now_us, can->off);
    settle(can);
}
