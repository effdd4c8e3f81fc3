#include "chip.h"

#include <string.h>

enum {
    CANSTAT = 0x0E, CANCTRL = 0x0F, TEC = 0x1C, REC = 0x1D, CNF3 = 0x28, CNF2 = 0x29, CNF1 = 0x2A,
    CANINTE = 0x2B, CANINTF = 0x2C, EFLG = 0x2D, RXB0CTRL = 0x60, RXB1CTRL = 0x70
};
enum { ABTF = 0x40, MLOA = 0x20, TXERR = 0x10, TXREQ = 0x08, BUKT = 0x04 };
enum { ERRIF = 0x20, MERRF = 0x80, TXBO = 0x20, RX0OVR = 0x40, RX1OVR = 0x80, OVERRUNS = 0xC0 };
enum { CONFIGURATION = 0x80, MODE = 0xE0 };
enum { DO_WRITE = 2, DO_READ = 3, DO_MODIFY = 5, DO_STATUS = 0xA0, DO_RX_STATUS = 0xB0, DO_RESET = 0xC0 };

static uint8_t txctrl(int buffer) {
    return (uint8_t)(0x30 + 0x10 * buffer);
}

static void violate(chip_t *chip, const char *what) {
    if (chip->violations++ == 0) {
        chip->violation = what;
    }
}

void chip_reset(chip_t *chip) {
    uint8_t filters[0x30];
    memcpy(filters, chip->registers, sizeof filters); /* as they were, or random */
    memset(chip->registers, 0, sizeof chip->registers);
    memcpy(chip->registers, filters, 0x0C);
    memcpy(&chip->registers[0x10], &filters[0x10], 0x0C);
    memcpy(&chip->registers[0x20], &filters[0x20], 8);
    chip->registers[CANCTRL] = 0x87;
    chip->registers[CANSTAT] = CONFIGURATION;
    chip->flying = CHIP_NONE;
    chip->tec = chip->rec = 0;
    chip->off = false;
}

/* Error flags follow the counters; ERRIF cannot be cleared as long as they stand. */
static void update_errors(chip_t *chip) {
    uint8_t flags = chip->registers[EFLG] & OVERRUNS;
    flags |= (chip->tec >= 96 || chip->rec >= 96) ? 0x01 : 0;
    flags |= chip->rec >= 96 ? 0x02 : 0;
    flags |= chip->tec >= 96 ? 0x04 : 0;
    flags |= chip->rec > 127 ? 0x08 : 0;
    flags |= chip->tec > 127 ? 0x10 : 0;
    flags |= chip->off ? TXBO : 0;
    chip->registers[EFLG] = flags;
    chip->registers[CANINTF] |= flags != 0 ? ERRIF : 0;
    chip->registers[TEC] = (uint8_t)chip->tec;
    chip->registers[REC] = (uint8_t)chip->rec;
}

static bool is_filter(uint8_t address) {
    return address < 0x30 && (address & 0x0F) < 0x0E &&
           (address < 0x0C || (address >= 0x10 && address < 0x1C) || (address >= 0x20 && address < 0x2B));
}

static bool in_transmit_buffer(uint8_t address, int *buffer) {
    *buffer = (address >> 4) - 3;
    return *buffer >= 0 && *buffer < 3 && (address & 0x0F) >= 1 && (address & 0x0F) <= 13;
}

static void write_control(chip_t *chip, int buffer, uint8_t value) {
    uint8_t *control = &chip->registers[txctrl(buffer)];
    const bool was = (*control & TXREQ) != 0, is = (value & TXREQ) != 0;
    *control = (uint8_t)((*control & (ABTF | MLOA | TXERR)) | (value & (TXREQ | 3)));
    if (!was && is) {
        if (chip->flying == buffer) {
            violate(chip, "request to send a buffer that is on the bus");
        }
        *control &= (uint8_t)~(ABTF | MLOA | TXERR);
    }
    if (was && !is) {
        if (chip->flying == buffer) {
            chip->abort_flying = true; /* goes on to its end */
        } else {
            *control |= ABTF;
        }
    }
}

static void write_register(chip_t *chip, uint8_t address, uint8_t value) {
    int buffer;
    address &= 0x7F;
    if ((address & 0x0F) == 0x0E) {
        return; /* CANSTAT */
    }
    if ((address & 0x0F) == 0x0F) {
        chip->registers[CANCTRL] = value;
        /* Normal mode comes with the next idle bus: here at once. */
        chip->registers[CANSTAT] = (uint8_t)((chip->registers[CANSTAT] & ~MODE) | (value & MODE));
        return;
    }
    if (is_filter(address) && (chip->registers[CANSTAT] & MODE) != CONFIGURATION) {
        violate(chip, "filters and bit timing written outside of configuration mode");
        return;
    }
    if (address == TEC || address == REC) {
        return;
    }
    if (address == txctrl(0) || address == txctrl(1) || address == txctrl(2)) {
        write_control(chip, (address >> 4) - 3, value);
        return;
    }
    if (in_transmit_buffer(address, &buffer) &&
        ((chip->registers[txctrl(buffer)] & TXREQ) || chip->flying == buffer)) {
        violate(chip, "a transmit buffer written while it is pending");
        return;
    }
    if (address == RXB0CTRL) {
        value &= 0x64;
        value |= (value & BUKT) ? 0x02 : 0;
    }
    if (address == EFLG) {
        value = (uint8_t)((value & OVERRUNS) | (chip->registers[EFLG] & ~OVERRUNS));
    }
    chip->registers[address] = value;
    update_errors(chip);
}

static uint8_t read_register(const chip_t *chip, uint8_t address) {
    address &= 0x7F;
    if ((address & 0x0F) == 0x0E) {
        return chip->registers[CANSTAT];
    }
    if ((address & 0x0F) == 0x0F) {
        return chip->registers[CANCTRL];
    }
    return chip->registers[address];
}

static uint8_t quick_status(const chip_t *chip) {
    const uint8_t flags = chip->registers[CANINTF];
    uint8_t status = flags & 3;
    for (int i = 0; i < 3; ++i) {
        status |= (uint8_t)((chip->registers[txctrl(i)] & TXREQ) ? 0x04 << (2 * i) : 0);
        status |= (uint8_t)((flags & (0x04 << i)) ? 0x08 << (2 * i) : 0);
    }
    return status;
}

static uint8_t receive_status(const chip_t *chip) {
    const uint8_t flags = chip->registers[CANINTF] & 3;
    if (flags == 0) {
        return 0;
    }
    const uint8_t at = (flags & 1) ? RXB0CTRL : RXB1CTRL;
    const bool extended = chip->registers[at + 2] & 0x08;
    const bool remote = chip->registers[at + (extended ? 5 : 2)] & (extended ? 0x40 : 0x10);
    return (uint8_t)(flags << 6 | extended << 4 | remote << 3 | (chip->registers[at] & 7));
}

void chip_select(chip_t *chip) {
    chip->position = 0;
}

static bool is_load(uint8_t instruction) {
    return (instruction & 0xF8) == 0x40 && (instruction & 7) < 6;
}

static bool is_fetch(uint8_t instruction) {
    return (instruction & 0xF9) == 0x90;
}

static void instruct(chip_t *chip, uint8_t in) {
    static const uint8_t loads[6] = {0x31, 0x36, 0x41, 0x46, 0x51, 0x56};
    static const uint8_t fetches[4] = {0x61, 0x66, 0x71, 0x76};
    chip->instruction = in;
    if (is_load(in)) {
        chip->address = loads[in & 7];
    } else if (is_fetch(in)) {
        chip->address = fetches[(in >> 1) & 3];
    } else if (in == DO_RESET) {
        chip_reset(chip);
    } else if ((in & 0xF8) == 0x80) {
        for (int i = 0; i < 3; ++i) {
            if (in & (1 << i)) {
                write_control(chip, i, chip->registers[txctrl(i)] | TXREQ);
            }
        }
    } else if (in != DO_WRITE && in != DO_READ && in != DO_MODIFY && in != DO_STATUS &&
               in != DO_RX_STATUS) {
        violate(chip, "an instruction that is none");
    }
}

static bool can_modify(uint8_t address) {
    return (address & 0x0F) == 0x0F || (address >= CNF3 && address <= EFLG) || address == 0x0C ||
           address == 0x0D || address == txctrl(0) || address == txctrl(1) || address == txctrl(2) ||
           address == RXB0CTRL || address == RXB1CTRL;
}

static void modify(chip_t *chip, uint8_t in) {
    const uint8_t mask = can_modify(chip->address) ? chip->mask : 0xFF;
    const uint8_t old = read_register(chip, chip->address);
    write_register(chip, chip->address, (uint8_t)((old & ~mask) | (in & mask)));
}

uint8_t chip_exchange(chip_t *chip, uint8_t in) {
    const unsigned position = chip->position++;
    if (chip->dead) {
        return 0xFF;
    }
    if (position == 0) {
        instruct(chip, in);
        return 0xFF;
    }
    const uint8_t instruction = chip->instruction;
    if (instruction == DO_STATUS) {
        return quick_status(chip);
    }
    if (instruction == DO_RX_STATUS) {
        return receive_status(chip);
    }
    if (is_fetch(instruction)) {
        return read_register(chip, chip->address++);
    }
    if (is_load(instruction)) {
        write_register(chip, chip->address++, in);
        return 0xFF;
    }
    if (position == 1) {
        chip->address = in & 0x7F;
        return 0xFF;
    }
    if (instruction == DO_READ) {
        return read_register(chip, chip->address++);
    }
    if (instruction == DO_WRITE) {
        write_register(chip, chip->address++, in);
    } else if (instruction == DO_MODIFY && position == 2) {
        chip->mask = in;
    } else if (instruction == DO_MODIFY && position == 3) {
        modify(chip, in);
    }
    return 0xFF;
}

void chip_deselect(chip_t *chip) {
    if (!chip->dead && chip->position > 0 && is_fetch(chip->instruction)) {
        chip->registers[CANINTF] &= (uint8_t)~((chip->instruction & 4) ? 2 : 1);
    }
    chip->position = 0;
}

bool chip_interrupts(const chip_t *chip) {
    return !chip->dead && (chip->registers[CANINTE] & chip->registers[CANINTF]) != 0;
}

bool chip_on_bus(const chip_t *chip) {
    return !chip->dead && !chip->off && (chip->registers[CANSTAT] & MODE) == 0;
}

unsigned chip_bit_clocks(const chip_t *chip) {
    const uint8_t cnf1 = chip->registers[CNF1], cnf2 = chip->registers[CNF2];
    const unsigned propagation = (cnf2 & 7) + 1u, phase1 = ((cnf2 >> 3) & 7) + 1u;
    const unsigned phase2 = (chip->registers[CNF3] & 7) + 1u, jump = (cnf1 >> 6) + 1u;
    if (!(cnf2 & 0x80) || phase2 < 2 || phase2 <= jump || propagation + phase1 < phase2) {
        return 0; /* which the data sheet forbids */
    }
    return 2u * ((cnf1 & 0x3F) + 1u) * (1u + propagation + phase1 + phase2);
}

int chip_pending(const chip_t *chip) {
    int best = CHIP_NONE;
    if (!chip_on_bus(chip)) {
        return CHIP_NONE;
    }
    for (int i = 0; i < 3; ++i) {
        const uint8_t control = chip->registers[txctrl(i)];
        if ((control & TXREQ) &&
            (best == CHIP_NONE || (control & 3) >= (chip->registers[txctrl(best)] & 3))) {
            best = i;
        }
    }
    return best;
}

static uint32_t identifier(const uint8_t *bytes, bool *extended) {
    const uint32_t standard = (uint32_t)bytes[0] << 3 | bytes[1] >> 5;
    *extended = (bytes[1] & 0x08) != 0;
    return *extended ? standard << 18 | (bytes[1] & 3u) << 16 | (uint32_t)bytes[2] << 8 | bytes[3]
                     : standard;
}

void chip_frame(const chip_t *chip, int buffer, chip_frame_t *frame) {
    const uint8_t *bytes = &chip->registers[txctrl(buffer) + 1];
    frame->id = identifier(bytes, &frame->extended);
    frame->remote = (bytes[4] & 0x40) != 0;
    frame->code = bytes[4] & 0x0F;
    memcpy(frame->data, bytes + 5, 8);
}

void chip_begin(chip_t *chip, int buffer) {
    chip->flying = buffer;
    chip->abort_flying = false;
}

void chip_succeed(chip_t *chip) {
    chip->registers[txctrl(chip->flying)] &= (uint8_t)~(TXREQ | TXERR | MLOA | ABTF);
    chip->registers[CANINTF] |= (uint8_t)(0x04 << chip->flying);
    chip->flying = CHIP_NONE;
    chip->tec -= chip->tec > 0;
    update_errors(chip);
}

void chip_fail(chip_t *chip, bool unacknowledged) {
    uint8_t *control = &chip->registers[txctrl(chip->flying)];
    *control |= TXERR;
    if (chip->abort_flying) {
        *control |= ABTF;
    }
    chip->flying = CHIP_NONE;
    chip->registers[CANINTF] |= MERRF;
    if (!unacknowledged || chip->tec <= 127) { /* ISO 11898-1: none when passive and alone */
        chip->tec += 8;
    }
    if (chip->tec > 255) {
        chip->off = true;
    }
    update_errors(chip);
}

/* Matches a filter with the mask of its buffer; \return which, or CHIP_NONE */
static int matches(const chip_t *chip, const chip_frame_t *frame, int buffer) {
    static const uint8_t filters[6] = {0x00, 0x04, 0x08, 0x10, 0x14, 0x18};
    bool extended, unused;
    const uint8_t *mask_bytes = &chip->registers[0x20 + 4 * buffer];
    const uint8_t as_extended[4] = {mask_bytes[0], mask_bytes[1] | 0x08, mask_bytes[2], mask_bytes[3]};
    const uint32_t mask = identifier(as_extended, &unused);
    for (int i = buffer ? 2 : 0; i < (buffer ? 6 : 2); ++i) {
        const uint8_t *bytes = &chip->registers[filters[i]];
        const uint32_t id = identifier(bytes, &extended);
        if (extended != frame->extended) {
            continue;
        }
        if (extended ? ((id ^ frame->id) & mask) == 0 : ((id ^ frame->id) & (mask >> 18)) == 0) {
            /* In a standard frame the mask's lower bits are for the first two bytes of data. */
            const uint16_t data = (uint16_t)(frame->data[0] << 8 | frame->data[1]);
            const uint16_t wanted = (uint16_t)(bytes[2] << 8 | bytes[3]);
            if (extended || ((data ^ wanted) & (mask & 0xFFFF)) == 0) {
                return i;
            }
        }
    }
    return CHIP_NONE;
}

static void store(chip_t *chip, const chip_frame_t *frame, int buffer, int filter) {
    uint8_t *at = &chip->registers[buffer ? RXB1CTRL : RXB0CTRL];
    const uint32_t standard = frame->extended ? frame->id >> 18 : frame->id;
    at[0] = (uint8_t)((at[0] & 0x66) | (frame->remote ? 8 : 0) | (filter & (buffer ? 7 : 1)));
    at[1] = (uint8_t)(standard >> 3);
    at[2] = (uint8_t)(standard << 5);
    at[3] = (uint8_t)(frame->extended ? frame->id >> 8 : 0x5A);
    at[4] = (uint8_t)(frame->extended ? frame->id : 0xA5);
    if (frame->extended) {
        at[2] |= (uint8_t)(0x08 | ((frame->id >> 16) & 3));
    } else if (frame->remote) {
        at[2] |= 0x10;
    }
    at[5] = (uint8_t)(frame->code | (frame->extended && frame->remote ? 0x40 : 0));
    memcpy(at + 6, frame->data, 8);
    chip->registers[CANINTF] |= buffer ? 2 : 1;
}

void chip_hear(chip_t *chip, const chip_frame_t *frame) {
    if (!chip_on_bus(chip)) {
        return;
    }
    chip->rec -= chip->rec > 0;
    const bool full0 = chip->registers[CANINTF] & 1, full1 = chip->registers[CANINTF] & 2;
    const int first = matches(chip, frame, 0), second = matches(chip, frame, 1);
    if (first != CHIP_NONE) {
        const bool rollover = chip->registers[RXB0CTRL] & BUKT;
        if (!full0) {
            store(chip, frame, 0, first);
        } else if (rollover && !full1) {
            store(chip, frame, 1, first);
        } else {
            chip->registers[EFLG] |= rollover ? RX1OVR : RX0OVR;
            ++chip->overruns;
        }
    } else if (second != CHIP_NONE) {
        if (!full1) {
            store(chip, frame, 1, second);
        } else {
            chip->registers[EFLG] |= RX1OVR;
            ++chip->overruns;
        }
    }
    update_errors(chip);
}

void chip_hear_error(chip_t *chip) {
    if (chip_on_bus(chip)) {
        chip->rec += chip->rec < 128;
        chip->registers[CANINTF] |= MERRF;
        update_errors(chip);
    }
}

void chip_recover(chip_t *chip) {
    chip->off = false;
    chip->tec = chip->rec = 0;
    update_errors(chip);
}
