/**
 * \file slcan.c
 * \brief Fuzzes the SLCAN codec: any bytes in, and any frame there and back.
 *
 * A decoded frame must encode to the line it came from, digits in upper case; every frame that
 * encodes must decode to itself. Every line gets one answer, which agrees with the result.
 */
#include "ccgen/slcan.h"

#include <string.h>

#include "input.h"

#define MARK 0xA5

/** The line so far, as an observer of the stream sees it. */
typedef struct {
    size_t length;
    uint8_t bytes[CCGEN_SLCAN_LINE_MAX];
} line_t;

static bool same_frame(const ccgen_frame_t *const a, const ccgen_frame_t *const b) {
    const size_t bytes = a->remote ? 0u : a->length;
    return (a->id == b->id) && (a->extended == b->extended) && (a->fd == b->fd) &&
           (a->remote == b->remote) && (a->rate_switch == b->rate_switch) &&
           (a->length == b->length) && (memcmp(a->data, b->data, bytes) == 0);
}

static uint8_t upper_digit(const uint8_t character) {
    return ((character >= 'a') && (character <= 'f')) ? (uint8_t)(character - 'a' + 'A')
                                                      : character;
}

/** The frame must stand for exactly this line. */
static void check_decoded(const ccgen_frame_t *const frame, const line_t *const line) {
    uint8_t again[CCGEN_SLCAN_ENCODED_MAX];
    const int length = ccgen_slcan_encode(frame, again, sizeof again);
    CHECK((length > 0) && ((size_t)length == (line->length + 1u)));
    CHECK(again[0] == line->bytes[0]);
    for (size_t i = 1; i < line->length; ++i) {
        CHECK(again[i] == upper_digit(line->bytes[i]));
    }
    CHECK(again[line->length] == '\r');
}

static void check_answer(const ccgen_slcan_t *const slcan, const uint8_t byte, const int result) {
    CHECK(slcan->reply_length <= CCGEN_SLCAN_REPLY_MAX);
    CHECK((byte == '\r') == (slcan->reply_length > 0u));
    if (slcan->reply_length > 0u) {
        const uint8_t last = slcan->reply[slcan->reply_length - 1u];
        CHECK(last == ((result < 0) ? '\a' : '\r'));
        CHECK((result == 0) || (slcan->reply_length == 1u));
    }
}

static void feed(ccgen_slcan_t *const slcan, line_t *const line, const uint8_t byte) {
    ccgen_frame_t untouched;
    ccgen_frame_t frame;
    const bool takes_frames = slcan->open && !slcan->listen_only;
    memset(&untouched, MARK, sizeof untouched);
    memset(&frame, MARK, sizeof frame);
    const int result = ccgen_slcan_feed(slcan, byte, &frame);
    CHECK((result == 1) || (result == 0) || (result == CCGEN_ERROR_FORMAT));
    check_answer(slcan, byte, result);
    if (result == 1) {
        CHECK(takes_frames && (line->length <= sizeof line->bytes));
        check_decoded(&frame, line);
    } else {
        CHECK(memcmp(&frame, &untouched, sizeof frame) == 0);
    }
    if (byte == '\r') {
        CHECK((line->length <= sizeof line->bytes) || (result == CCGEN_ERROR_FORMAT));
        line->length = 0;
    } else if (byte != '\n') {
        if (line->length < sizeof line->bytes) {
            line->bytes[line->length] = byte;
        }
        ++line->length;
    }
}

/** A line that is a frame, or nearly. \return its length. */
static size_t near_frame(input_t *const input, uint8_t *const text) {
    static const char kinds[] = "tTrRdDbB";
    static const uint8_t lengths[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    const uint8_t what = take8(input);
    const uint8_t kind = what % 8u;
    const uint8_t code = take8(input) % 16u;
    const uint32_t id = take32(input) >> (what / 8u);
    char digits[9];
    (void)snprintf(digits, sizeof digits, "%08lx", (unsigned long)id);
    size_t length = 0;
    text[length++] = (uint8_t)kinds[kind];
    for (size_t i = ((kind % 2u) == 0u) ? 5u : 0u; i < 8u; ++i) {
        text[length++] = (uint8_t)digits[i];
    }
    text[length++] = (uint8_t)"0123456789ABCDEF"[code];
    for (size_t i = ((kind / 2u) == 1u) ? 0u : (2u * lengths[code]); i > 0u; --i) {
        text[length++] = (uint8_t)"0123456789abcdefABCDEF"[take8(input) % 22u];
    }
    const uint8_t harm = take8(input);
    if (harm >= 192u) {
        text[take8(input) % length] = take8(input);
    } else if (harm >= 160u) {
        --length;
    } else if (harm >= 128u) {
        text[length++] = (uint8_t)'0';
    }
    return length;
}

/** Whatever came before: after the end of a line, commands and frames are understood. */
static void check_alive(ccgen_slcan_t *const slcan) {
    static const char text[] = "\rC\rS6\rO\rt1230\r";
    ccgen_frame_t frame;
    int result = 0;
    for (size_t i = 0; text[i] != '\0'; ++i) {
        result = ccgen_slcan_feed(slcan, (uint8_t)text[i], &frame);
        CHECK((i == 0u) || (result >= 0));
    }
    CHECK((result == 1) && (frame.id == 0x123u));
}

/** Any bytes, commands, and lines that are nearly frames. */
static void stream(input_t input) {
    static const char commands[] = "O\rL\rC\rV\rN\rF\rO\r";
    ccgen_slcan_t *const slcan = (ccgen_slcan_t *)malloc(sizeof *slcan); /* watched at its ends */
    line_t line = {0, {0}};
    CHECK((slcan != NULL) && (ccgen_slcan_init(slcan) == CCGEN_OK));
    while (input.left > 0u) {
        uint8_t text[CCGEN_SLCAN_LINE_MAX + 2];
        size_t length = 0;
        const uint8_t what = take8(&input);
        if ((what % 4u) == 0u) {
            length = near_frame(&input, text);
            text[length++] = '\r';
        } else if ((what % 4u) == 1u) {
            memcpy(text, &commands[2u * (what / 4u % 7u)], 2);
            length = 2;
        } else {
            for (uint8_t n = what / 4u; n > 0u; --n) {
                text[length++] = take8(&input);
            }
        }
        for (size_t i = 0; i < length; ++i) {
            feed(slcan, &line, text[i]);
        }
    }
    check_alive(slcan);
    free(slcan);
}

/** Encodes the input as a frame into a buffer of any size and, where it exists, decodes it. */
static void round_trip(input_t input) {
    ccgen_slcan_t slcan = CCGEN_ZERO;
    ccgen_frame_t frame;
    ccgen_frame_t decoded;
    const uint8_t kind = take8(&input);
    const size_t capacity = take8(&input) % (CCGEN_SLCAN_ENCODED_MAX + 1u);
    memset(&frame, 0, sizeof frame);
    frame.extended = (kind & 1u) != 0u;
    frame.fd = (kind & 2u) != 0u;
    frame.remote = (kind & 4u) != 0u;
    frame.rate_switch = frame.fd && ((kind & 8u) != 0u);
    frame.length = take8(&input);
    frame.id = take32(&input);
    for (size_t i = 0; i < sizeof frame.data; ++i) {
        frame.data[i] = take8(&input);
    }
    uint8_t *const text = (uint8_t *)malloc(capacity + 1u); /* one more: malloc(0) may be NULL */
    CHECK(text != NULL);
    memset(text, MARK, capacity + 1u);
    const int length = ccgen_slcan_encode(&frame, text, capacity);
    CHECK((length == CCGEN_ERROR_FORMAT) || (length == CCGEN_ERROR_RANGE) || (length > 0));
    CHECK((length < 0) || ((size_t)length <= capacity));
    for (size_t i = (length > 0) ? (size_t)length : 0u; i <= capacity; ++i) {
        CHECK(text[i] == MARK);
    }
    slcan.open = true;
    for (int i = 0; i < length; ++i) {
        const int result = ccgen_slcan_feed(&slcan, text[i], &decoded);
        CHECK(result == ((i == (length - 1)) ? 1 : 0));
    }
    CHECK((length < 0) || same_frame(&decoded, &frame));
    free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *const data, const size_t size) {
    const input_t input = {data, size};
    stream(input);
    round_trip(input);
    return 0;
}
