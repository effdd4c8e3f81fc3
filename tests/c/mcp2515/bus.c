#include "bus.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SPANS 256
#define RECOVERY_BITS (128u * 11u)

typedef struct {
    uint64_t at_ns;
    chip_frame_t frame;
} sending_t;

typedef struct {
    char kind; /* a: alone, b: broken, d: deaf, r: reset, x: dead */
    uint64_t from_ns, to_ns;
} span_t;

struct bus {
    chip_t chip;
    uint64_t now_ns, bit_ns, end_ns, busy_until_ns, quiet_since_ns;
    uint32_t oscillator_hz, bit_rate;
    sending_t *sendings;
    size_t sendings_number, next;
    span_t spans[SPANS];
    size_t spans_number;
    bool busy, from_chip; /* a frame is on the bus, and whose */
    bool was_reset[SPANS];
    chip_frame_t flying;
};

static bool during(const bus_t *bus, char kind) {
    for (size_t i = 0; i < bus->spans_number; ++i) {
        const span_t *span = &bus->spans[i];
        if (span->kind == kind && span->from_ns <= bus->now_ns && bus->now_ns < span->to_ns) {
            return true;
        }
    }
    return false;
}

static void add_frame(bus_t *bus, const char *line) {
    uint64_t at;
    unsigned id, flags, code;
    char hex[32];
    if (sscanf(line, "frame %" SCNu64 " %x %x %u %31s", &at, &id, &flags, &code, hex) != 5) {
        fprintf(stderr, "script: %s", line);
        exit(2);
    }
    bus->sendings = realloc(bus->sendings, (bus->sendings_number + 1) * sizeof *bus->sendings);
    sending_t *sending = &bus->sendings[bus->sendings_number++];
    memset(sending, 0, sizeof *sending);
    sending->at_ns = at * 1000;
    sending->frame.id = id;
    sending->frame.extended = flags & 1;
    sending->frame.remote = flags & 2;
    sending->frame.code = (uint8_t)code;
    for (size_t i = 0; i < 8 && hex[2 * i] != '\0' && hex[2 * i] != '-'; ++i) {
        unsigned byte = 0;
        sscanf(&hex[2 * i], "%2x", &byte);
        sending->frame.data[i] = (uint8_t)byte;
    }
}

static void add_span(bus_t *bus, char kind, uint64_t from, uint64_t to) {
    if (bus->spans_number == SPANS) {
        fprintf(stderr, "script: too many spans\n");
        exit(2);
    }
    bus->spans[bus->spans_number++] = (span_t){kind, from * 1000, to * 1000};
}

bus_t *bus_new(uint32_t oscillator_hz, uint32_t bit_rate) {
    bus_t *bus = calloc(1, sizeof *bus);
    char line[128];
    bus->oscillator_hz = oscillator_hz;
    bus->bit_rate = bit_rate;
    bus->bit_ns = 1000000000u / bit_rate;
    memset(bus->chip.registers, 0xA5, sizeof bus->chip.registers);
    chip_reset(&bus->chip);
    while (fgets(line, sizeof line, stdin) != NULL) {
        uint64_t from = 0, to = 0;
        char word[16] = "";
        sscanf(line, "%15s %" SCNu64 " %" SCNu64, word, &from, &to);
        if (strcmp(word, "frame") == 0) {
            add_frame(bus, line);
        } else if (strcmp(word, "end") == 0) {
            bus->end_ns = from * 1000;
        } else {
            add_span(bus, strcmp(word, "dead") == 0 ? 'x' : word[0], from, to);
        }
    }
    return bus;
}

chip_t *bus_chip(bus_t *bus) {
    return &bus->chip;
}

bool bus_is_deaf(const bus_t *bus) {
    return during(bus, 'd');
}

/* Bits of a frame with the gap behind it; stuff bits are left out. */
static unsigned bits(const chip_frame_t *frame) {
    const unsigned length = frame->remote ? 0 : frame->code > 8 ? 8 : frame->code;
    return (frame->extended ? 67u : 47u) + 8u * length;
}

/* What arbitration compares: base identifier, then whether it goes on, then the rest. */
static uint32_t rank(const chip_frame_t *frame) {
    return frame->extended ? (frame->id >> 18) << 19 | 1u << 18 | (frame->id & 0x3FFFF)
                           : frame->id << 19;
}

static void say(const bus_t *bus) {
    const chip_frame_t *frame = &bus->flying;
    printf("%" PRIu64 " %x %x %u ", bus->now_ns / 1000, (unsigned)frame->id,
           (unsigned)(frame->extended | frame->remote << 1), frame->code);
    for (int i = 0; i < 8 && i < frame->code; ++i) {
        printf("%02x", frame->data[i]);
    }
    printf("%s\n", frame->code == 0 ? "-" : "");
}

/* The chip hears and is heard at the rate of the bus alone. */
static bool in_step(const bus_t *bus) {
    const unsigned clocks = chip_bit_clocks(&bus->chip);
    return clocks != 0 && clocks * (uint64_t)bus->bit_rate == bus->oscillator_hz;
}

static void finish(bus_t *bus) {
    bus->busy = false;
    if (bus->from_chip) {
        if (bus->chip.flying == CHIP_NONE) {
            return; /* it was reset meanwhile */
        }
        if (during(bus, 'b') || !in_step(bus)) {
            chip_fail(&bus->chip, false);
        } else if (during(bus, 'a')) {
            chip_fail(&bus->chip, true);
        } else {
            say(bus);
            chip_succeed(&bus->chip);
        }
    } else if (in_step(bus)) {
        chip_hear(&bus->chip, &bus->flying);
    } else {
        chip_hear_error(&bus->chip);
    }
}

/* Lets the one with the lowest identifier begin; the bus is idle. */
static void arbitrate(bus_t *bus) {
    const int pending = chip_pending(&bus->chip);
    chip_frame_t own, *other = NULL;
    while (bus->next < bus->sendings_number && bus->sendings[bus->next].at_ns <= bus->now_ns) {
        if (during(bus, 'a') || during(bus, 'b')) {
            ++bus->next; /* the others give up */
            continue;
        }
        other = &bus->sendings[bus->next].frame;
        break;
    }
    if (pending != CHIP_NONE) {
        chip_frame(&bus->chip, pending, &own);
    }
    if (pending != CHIP_NONE && (other == NULL || rank(&own) < rank(other))) {
        chip_begin(&bus->chip, pending);
        bus->flying = own;
        bus->from_chip = true;
    } else if (other != NULL) {
        bus->flying = *other;
        bus->from_chip = false;
        ++bus->next;
    } else {
        return;
    }
    bus->busy = true;
    bus->busy_until_ns = bus->now_ns + bits(&bus->flying) * bus->bit_ns;
}

static void mishaps(bus_t *bus) {
    for (size_t i = 0; i < bus->spans_number; ++i) {
        if (bus->spans[i].kind == 'r' && !bus->was_reset[i] && bus->spans[i].from_ns <= bus->now_ns) {
            bus->was_reset[i] = true;
            chip_reset(&bus->chip);
        }
    }
    const bool dead = during(bus, 'x');
    if (dead && !bus->chip.dead) {
        chip_reset(&bus->chip);
    }
    bus->chip.dead = dead;
    if (!bus->chip.off || during(bus, 'b')) {
        bus->quiet_since_ns = bus->now_ns;
    } else if (bus->now_ns - bus->quiet_since_ns >= RECOVERY_BITS * bus->bit_ns) {
        chip_recover(&bus->chip);
    }
}

bool bus_advance(bus_t *bus, uint64_t now_ns) {
    while (bus->busy && bus->busy_until_ns <= now_ns) {
        bus->now_ns = bus->busy_until_ns;
        mishaps(bus);
        finish(bus);
        arbitrate(bus);
    }
    bus->now_ns = now_ns;
    mishaps(bus);
    if (!bus->busy) {
        arbitrate(bus);
    }
    return bus->now_ns < bus->end_ns;
}

void bus_end(const bus_t *bus) {
    printf("model %u %u %s\n", (unsigned)bus->chip.overruns, (unsigned)bus->chip.violations,
           bus->chip.violations ? bus->chip.violation : "-");
}
