/**
 * \file can_fdcan.c
 * \brief See can_fdcan.h. Names are the reference manual's.
 */
#include "can_fdcan.h"

#include "can_timing.h"

/* Offsets of registers, in bytes. */
#define DBTP 0x0Cu
#define CCCR 0x18u
#define NBTP 0x1Cu
#define PSR 0x44u
#define TDCR 0x48u
#define IR 0x50u
#define IE 0x54u
#define ILS 0x58u
#define ILE 0x5Cu
#define RXGFC 0x80u
#define RXF0S 0x90u
#define RXF0A 0x94u
#define TXBC 0xC0u
#define TXFQS 0xC4u
#define TXBRP 0xC8u
#define TXBAR 0xCCu
#define TXBCR 0xD0u
#define TXBTO 0xD4u

#define CCCR_INIT (1u << 0)
#define CCCR_CCE (1u << 1)
#define CCCR_CSR (1u << 4)
#define CCCR_FDOE (1u << 8)
#define CCCR_BRSE (1u << 9)
#define DBTP_TDC (1u << 23)
#define PSR_LEC 7u
#define PSR_BO (1u << 7)
#define PSR_DLEC (7u << 8)
#define IR_RF0N (1u << 0)
#define IR_RF0L (1u << 2)
#define ILE_EINT0 (1u << 0)
#define RXGFC_ANF_REJECT ((2u << 4) | (2u << 2))
#define RXGFC_RRF 3u /* remote frames are rejected */
#define RXF0S_F0FL 0xFu

/* The message RAM, in words: 28 standard filters, 8 extended ones, two receive FIFOs, the event
 * FIFO, the transmit buffers. */
#define STANDARD_FILTERS 0u
#define EXTENDED_FILTERS 28u
#define FIFO0 44u
#define BUFFERS 158u
#define WORDS 212u
#define ELEMENT 18u
#define STANDARD_MAX 28u
#define EXTENDED_MAX 8u

#define ELEMENT_XTD (1u << 30)
#define ELEMENT_RTR (1u << 29)
#define ELEMENT_FDF (1u << 21)
#define ELEMENT_BRS (1u << 20)

/** Reads of a flag until the controller counts as silent. */
#define PATIENCE 100000u
/** Frames that are read at once, so that a broken controller holds nobody up. */
#define AT_ONCE 16u
/** Longest delay from a transceiver's input over the bus to its output (ISO 11898-2:2016). */
#define DELAY_NS 255u

static const uint8_t lengths[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

static uint32_t get(const can_fdcan_t *const can, const uint32_t offset) {
    return CAN_PORT_READ(&can->registers[offset / 4u]);
}

static void put(const can_fdcan_t *const can, const uint32_t offset, const uint32_t value) {
    CAN_PORT_WRITE(&can->registers[offset / 4u], value);
}

static uint32_t get_word(const can_fdcan_t *const can, const uint32_t word) {
    return CAN_PORT_READ(&can->memory[word]);
}

static void put_word(const can_fdcan_t *const can, const uint32_t word, const uint32_t value) {
    CAN_PORT_WRITE(&can->memory[word], value);
}

typedef struct {
    uint32_t nominal;      /* NBTP */
    uint32_t data;         /* DBTP */
    uint32_t compensation; /* TDCR */
} can_fdcan_timing_t;

/** Data phase, its transmitter delay compensated at the sample point. */
static bool find_data_timing(const can_port_config_t *const config, can_fdcan_timing_t *const bits) {
    static const can_timing_limits_t limits = {32u, 1u, 32u, 1u, 16u, 16u};
    can_timing_t timing;
    if (!can_timing_find(config->clock_hz, config->data_bitrate, &limits, &timing)) {
        return false;
    }
    bits->data = ((timing.prescaler - 1u) << 16) | ((timing.segment1 - 1u) << 8) |
                 ((timing.segment2 - 1u) << 4) | (timing.jump - 1u);
    const uint32_t clocks = timing.prescaler * (1u + timing.segment1); /* to the sample point */
    if (timing.prescaler <= 2u) {
        bits->data |= DBTP_TDC;
        bits->compensation = clocks << 8;
        return true;
    }
    return clocks >= (config->clock_hz / 1000u * DELAY_NS + 999999u) / 1000000u;
}

static bool find_timing(const can_port_config_t *const config, can_fdcan_timing_t *const bits) {
    static const can_timing_limits_t limits = {512u, 1u, 256u, 1u, 128u, 128u};
    can_timing_t timing;
    bits->data = 0u;
    bits->compensation = 0u;
    if (!can_timing_find(config->clock_hz, config->bitrate, &limits, &timing)) {
        return false;
    }
    bits->nominal = ((timing.jump - 1u) << 25) | ((timing.prescaler - 1u) << 16) |
                    ((timing.segment1 - 1u) << 8) | (timing.segment2 - 1u);
    return !config->fd || (config->data_bitrate == 0u) || find_data_timing(config, bits);
}

static bool is_at(const can_fdcan_t *const can, const uint32_t bits) {
    for (uint32_t i = 0; i < PATIENCE; ++i) {
        if ((get(can, CCCR) & bits) == bits) {
            return true;
        }
    }
    return false;
}

/** Takes the controller off the bus, open for changes, its FIFOs and buffers empty. */
static bool stop(const can_fdcan_t *const can) {
    put(can, CCCR, CCCR_INIT);
    if (!is_at(can, CCCR_INIT)) {
        return false;
    }
    put(can, CCCR, CCCR_INIT | CCCR_CCE);
    return is_at(can, CCCR_INIT | CCCR_CCE);
}

/** Lets own identifiers into FIFO 0, the first that agrees with `id` in the bits of `mask`. */
static void set_filters(const can_fdcan_t *const can, const can_port_config_t *const config) {
    const uint32_t count = config->filter_count;
    for (uint32_t i = 0; i < count; ++i) {
        const can_port_filter_t *const filter = &config->filters[i];
        if (config->extended) {
            put_word(can, EXTENDED_FILTERS + (2u * i), (1u << 29) | filter->id);
            put_word(can, EXTENDED_FILTERS + (2u * i) + 1u, (2u << 30) | filter->mask);
        } else {
            put_word(can, STANDARD_FILTERS + i,
                     (2u << 30) | (1u << 27) | (filter->id << 16) | filter->mask);
        }
    }
    put(can, RXGFC, RXGFC_ANF_REJECT | RXGFC_RRF | (count << (config->extended ? 24 : 16)));
}

int can_fdcan_start(can_fdcan_t *const can, volatile uint32_t *const registers,
                    volatile uint32_t *const memory, const can_port_config_t *const config) {
    static const can_fdcan_t nothing; /* zero */
    can_fdcan_timing_t bits;
    *can = nothing;
    can->registers = registers;
    can->memory = memory;
    can->cycle_us = config->cycle_us;
    can->fd = config->fd;
    if (!find_timing(config, &bits)) {
        return CAN_PORT_ERROR_TIMING;
    }
    if (config->filter_count > (config->extended ? EXTENDED_MAX : STANDARD_MAX)) {
        return CAN_PORT_ERROR_FILTERS;
    }
    if (!stop(can)) {
        return CAN_PORT_ERROR_SILENT;
    }
    for (uint32_t i = 0; i < WORDS; ++i) {
        put_word(can, i, 0u);
    }
    put(can, NBTP, bits.nominal);
    if (bits.data != 0u) {
        put(can, DBTP, bits.data);
        put(can, TDCR, bits.compensation);
    }
    set_filters(can, config);
    put(can, TXBC, 0u); /* a FIFO */
    put(can, IR, get(can, IR));
    put(can, ILS, 0u); /* line 0 */
    put(can, IE, IR_RF0N);
    put(can, ILE, ILE_EINT0);
    put(can, CCCR, CCCR_INIT | CCCR_CCE | (can->fd ? CCCR_FDOE : 0u) |
                       ((bits.data != 0u) ? CCCR_BRSE : 0u));
    put(can, CCCR, get(can, CCCR) & ~(CCCR_INIT | CCCR_CCE | CCCR_CSR));
    return CAN_PORT_OK;
}

/** Reads the oldest frame and gives its place back. */
static void read_frame(const can_fdcan_t *const can, ccgen_frame_t *const frame) {
    const uint32_t place = (get(can, RXF0S) >> 8) & 3u;
    const uint32_t at = FIFO0 + (place * ELEMENT);
    const uint32_t header = get_word(can, at);
    const uint32_t kind = get_word(can, at + 1u);
    const uint8_t length = lengths[(kind >> 16) & 0xFu];
    frame->extended = (header & ELEMENT_XTD) != 0u;
    frame->id = frame->extended ? header & 0x1FFFFFFFu : (header >> 18) & 0x7FFu;
    frame->fd = (kind & ELEMENT_FDF) != 0u;
    frame->remote = (header & ELEMENT_RTR) != 0u;
    frame->rate_switch = (kind & ELEMENT_BRS) != 0u;
    /* On classic CAN 9 to 15 mean 8 (ISO 11898-1). */
    frame->length = (uint8_t)((!frame->fd && (length > 8u)) ? 8u : length);
    for (uint32_t i = 0; i < frame->length; i += 4u) {
        const uint32_t word = get_word(can, at + 2u + (i / 4u));
        for (uint32_t k = 0; k < 4u; ++k) {
            frame->data[i + k] = (uint8_t)(word >> (8u * k));
        }
    }
    put(can, RXF0A, place);
}

static void read_all(can_fdcan_t *const can, const uint32_t now_us) {
    ccgen_frame_t frame;
    put(can, IR, IR_RF0N); /* before the frames are read: what comes meanwhile asks again */
    for (uint32_t i = 0; (i < AT_ONCE) && ((get(can, RXF0S) & RXF0S_F0FL) != 0u); ++i) {
        read_frame(can, &frame);
        can_port_arrived(&can->counters, &can->arrivals, &frame, now_us);
    }
    if ((get(can, IR) & IR_RF0L) != 0u) {
        put(can, IR, IR_RF0L);
        can->counters.dropped = can->counters.dropped + 1u;
    }
}

void can_fdcan_receive(can_fdcan_t *const can, const uint32_t now_us) {
    if (can->reading) {
        put(can, IE, 0u); /* service() lets it through again */
    } else {
        read_all(can, now_us);
    }
}

/** Counts what has left, or was given up, since. */
static void settle(can_fdcan_t *const can) {
    const uint32_t done = can->pending & ~get(can, TXBRP);
    const uint32_t sent = get(can, TXBTO);
    for (uint32_t i = 0; i < CAN_FDCAN_BUFFERS; ++i) {
        const uint32_t bit = 1u << i;
        if ((done & bit) != 0u) {
            can->pending &= ~bit;
            if ((sent & bit) != 0u) {
                can->counters.sent += 1u;
            } else {
                can->counters.aborted += 1u;
            }
        }
    }
}

/** \return the code of a length; 16: no frame has it. */
static uint32_t length_code(const ccgen_frame_t *const frame) {
    uint32_t code = 0;
    while ((code < 16u) && (lengths[code] != frame->length)) {
        ++code;
    }
    return (!frame->fd && (code > 8u)) ? 16u : code;
}

static void write_frame(const can_fdcan_t *const can, const uint32_t buffer,
                        const ccgen_frame_t *const frame, const uint32_t code) {
    const uint32_t at = BUFFERS + (buffer * ELEMENT);
    put_word(can, at,
             (frame->extended ? frame->id | ELEMENT_XTD : frame->id << 18) |
                 (frame->remote ? ELEMENT_RTR : 0u));
    put_word(can, at + 1u,
             (code << 16) | (frame->fd ? ELEMENT_FDF : 0u) |
                 (frame->rate_switch ? ELEMENT_BRS : 0u));
    for (uint32_t i = 0; i < frame->length; i += 4u) {
        const uint8_t *const data = &frame->data[i];
        put_word(can, at + 2u + (i / 4u),
                 (uint32_t)data[0] | ((uint32_t)data[1] << 8) | ((uint32_t)data[2] << 16) |
                     ((uint32_t)data[3] << 24));
    }
}

int can_fdcan_transmit(can_fdcan_t *const can, const ccgen_frame_t *const frame,
                       const uint32_t now_us) {
    const uint32_t code = length_code(frame);
    if ((code > 15u) || (frame->fd && !can->fd)) {
        return CAN_PORT_ERROR_FRAME;
    }
    settle(can);
    const uint32_t status = get(can, TXFQS);
    const uint32_t buffer = (status >> 16) & 3u;
    if (can->off || ((status & 7u) == 0u) || (buffer >= CAN_FDCAN_BUFFERS) ||
        ((can->pending & (1u << buffer)) != 0u)) {
        return 0;
    }
    write_frame(can, buffer, frame, code);
    can->pending |= 1u << buffer;
    can->handed_us[buffer] = now_us;
    put(can, TXBAR, 1u << buffer);
    return 1;
}

/** Aborts what has waited for longer than a cycle, or all. */
static void abort_old(const can_fdcan_t *const can, const uint32_t now_us, const bool all) {
    uint32_t old = 0;
    for (uint32_t i = 0; i < CAN_FDCAN_BUFFERS; ++i) {
        const bool late = all || (now_us - can->handed_us[i] > can->cycle_us);
        if (late && ((can->pending & (1u << i)) != 0u)) {
            old |= 1u << i;
        }
    }
    if (old != 0u) {
        put(can, TXBCR, old);
    }
}

/**
 * Counts errors since the last look, and comes back from bus-off: the controller set INIT by
 * itself, and begins to recover once that is cleared. Nothing may be pending by then.
 */
static void look_at_bus(can_fdcan_t *const can) {
    const uint32_t status = get(can, PSR); /* which forgets the last error */
    const uint32_t code = status & PSR_LEC;
    const uint32_t data_code = (status & PSR_DLEC) >> 8;
    const bool is_off = (status & PSR_BO) != 0u;
    if (((code != 0u) && (code != 7u)) || ((data_code != 0u) && (data_code != 7u))) {
        can->counters.errors += 1u;
    }
    if (is_off && !can->off) {
        can->counters.bus_off += 1u;
    } else if (can->off && ((get(can, CCCR) & CCCR_INIT) != 0u) && (can->pending == 0u)) {
        put(can, CCCR, get(can, CCCR) & ~CCCR_INIT);
    }
    can->off = is_off || ((get(can, CCCR) & CCCR_INIT) != 0u);
}

void can_fdcan_service(can_fdcan_t *const can, const uint32_t now_us) {
    can->reading = true;
    read_all(can, now_us);
    can->reading = false;
    put(can, IE, IR_RF0N);
    look_at_bus(can);
    abort_old(can, now_us, can->off);
    settle(can);
}
