#include "ccgen/slcan.h"

#define STANDARD_ID_DIGITS 3u
#define EXTENDED_ID_DIGITS 8u
#define STANDARD_ID_MAX 0x7FFu
#define EXTENDED_ID_MAX 0x1FFFFFFFu
#define CLASSIC_LENGTH_MAX 8u
#define LENGTH_CODES 16u
#define LOWER_CASE 0x20u
#define NO_DIGIT 0xFFu

CCGEN_STATIC_ASSERT(('0' == 0x30) && ('A' == 0x41) && ('a' == 0x61), characters_are_ascii);
CCGEN_STATIC_ASSERT(CCGEN_SLCAN_LINE_MAX < UINT8_MAX, line_is_counted_in_one_byte);

/** \return bytes of data that a length code from 0 to F stands for. */
static uint8_t length_of_code(const uint8_t code) {
    static const uint8_t lengths[LENGTH_CODES] = {0, 1,  2,  3,  4,  5,  6,  7,
                                                  8, 12, 16, 20, 24, 32, 48, 64};
    return lengths[code];
}

static uint8_t digit_value(const uint8_t character) {
    if ((character >= '0') && (character <= '9')) { /* MISRA 10.4 */
        return (uint8_t)(character - '0'); /* MISRA 10.4 */
    }
    const uint8_t lower = (uint8_t)(character | LOWER_CASE);
    if ((lower >= 'a') && (lower <= 'f')) { /* MISRA 10.4 */
        return (uint8_t)(lower - 'a' + 10); /* MISRA 10.4 */
    }
    return NO_DIGIT;
}

static uint8_t digit_of(const uint32_t value) {
    const uint8_t nibble = (uint8_t)(value & 0x0Fu);
    return (uint8_t)((nibble < 10u) ? (nibble + '0') : (nibble - 10 + 'A')); /* MISRA 10.4 */
}

static bool read_number(const uint8_t *const text, const uint8_t digits, uint32_t *const number) {
    uint32_t value = 0;
    for (uint8_t i = 0; i < digits; ++i) {
        const uint8_t digit = digit_value(text[i]);
        if (digit == NO_DIGIT) {
            return false;
        }
        value = (value << 4) | digit;
    }
    *number = value;
    return true;
}

static uint8_t *write_number(uint8_t *text, const uint32_t number, const uint8_t digits) {
    for (uint8_t i = digits; i > 0u; --i) {
        *text = digit_of(number >> (4u * (i - 1u))); /* MISRA 10.7 */
        ++text;
    }
    return text;
}

static uint8_t id_digits(const ccgen_frame_t *const frame) {
    return frame->extended ? EXTENDED_ID_DIGITS : STANDARD_ID_DIGITS;
}

static bool id_exists(const ccgen_frame_t *const frame) {
    return frame->id <= (frame->extended ? EXTENDED_ID_MAX : STANDARD_ID_MAX);
}

/** Sets the kind of frame from a line's first character. \return whether it names one. */
static bool read_kind(const uint8_t character, ccgen_frame_t *const frame) {
    const uint8_t lower = (uint8_t)(character | LOWER_CASE);
    frame->extended = (character != lower);
    frame->remote = (lower == 'r'); /* MISRA 10.4 */
    frame->rate_switch = (lower == 'b'); /* MISRA 10.4 */
    frame->fd = (lower == 'd') || (lower == 'b'); /* MISRA 10.4 */
    return (lower == 't') || frame->remote || frame->fd; /* MISRA 10.4 */
}

static uint8_t kind_character(const ccgen_frame_t *const frame) {
    const uint8_t fd = (uint8_t)(frame->rate_switch ? 'b' : 'd');
    const uint8_t classic = (uint8_t)(frame->remote ? 'r' : 't');
    const uint8_t lower = frame->fd ? fd : classic;
    return (uint8_t)(frame->extended ? (lower & ~LOWER_CASE) : lower); /* MISRA 10.8 */
}

static bool read_data(const uint8_t *const text, ccgen_frame_t *const frame) {
    for (uint8_t i = 0; i < frame->length; ++i) {
        uint32_t byte = 0;
        if (!read_number(&text[(size_t)2u * i], 2, &byte)) {
            return false;
        }
        frame->data[i] = (uint8_t)byte;
    }
    return true;
}

/** Decodes a complete line into a frame. \return whether it is one. */
static bool read_frame(const uint8_t *const line, const uint8_t length,
                       ccgen_frame_t *const frame) {
    ccgen_frame_t read = CCGEN_ZERO;
    uint32_t code = 0;
    if (!read_kind(line[0], &read)) {
        return false;
    }
    const uint8_t digits = id_digits(&read);
    const uint8_t head = (uint8_t)(1u + digits + 1u);
    if ((length < head) || !read_number(&line[1], digits, &read.id) || !id_exists(&read) ||
        !read_number(&line[1u + digits], 1, &code)) {
        return false;
    }
    read.length = length_of_code((uint8_t)code);
    const uint8_t characters = (uint8_t)(read.remote ? 0u : (2u * read.length));
    if ((!read.fd && (read.length > CLASSIC_LENGTH_MAX)) || (length != (head + characters)) ||
        (!read.remote && !read_data(&line[head], &read))) {
        return false;
    }
    *frame = read;
    return true;
}

static void answer(ccgen_slcan_t *const slcan, const char *const text) {
    uint8_t length = 0;
    while ((length < CCGEN_SLCAN_REPLY_MAX) && (text[length] != '\0')) {
        slcan->reply[length] = (uint8_t)text[length];
        ++length;
    }
    slcan->reply_length = length;
}

static int open_channel(ccgen_slcan_t *const slcan, const bool listen_only) {
    slcan->open = true;
    slcan->listen_only = listen_only;
    return 0;
}

static int close_channel(ccgen_slcan_t *const slcan) {
    slcan->open = false;
    slcan->listen_only = false;
    return 0;
}

static int report(ccgen_slcan_t *const slcan, const char *const text) {
    answer(slcan, text);
    return 0;
}

/** \return 0 when the one digit after the command is within 0 to `last` and the channel fits. */
static int choose(const ccgen_slcan_t *const slcan, const uint8_t last, const bool only_closed) {
    const uint8_t digit = slcan->line[1];
    const bool possible = !(only_closed && slcan->open);
    return (possible && (slcan->length == 2u) && (digit >= '0') && (digit <= last)) /* MISRA 10.4 */
               ? 0
               : CCGEN_ERROR_FORMAT;
}

static int set_bit_timing(const ccgen_slcan_t *const slcan) {
    uint32_t timing = 0;
    return (!slcan->open && (slcan->length == 5u) && read_number(&slcan->line[1], 4, &timing))
               ? 0
               : CCGEN_ERROR_FORMAT;
}

/** Carries out a command of one character. */
static int command(ccgen_slcan_t *const slcan) {
    switch (slcan->line[0]) {
        case 'O':
            return open_channel(slcan, false);
        case 'L':
            return open_channel(slcan, true);
        case 'C':
            return close_channel(slcan);
        case 'V':
            return report(slcan, "V0101\r");
        case 'N':
            return report(slcan, "NCCGN\r");
        case 'F':
            return report(slcan, "F00\r");
        default:
            return CCGEN_ERROR_FORMAT;
    }
}

/** Carries out a complete line, whatever it is. */
static int carry_out(ccgen_slcan_t *const slcan, ccgen_frame_t *const frame) {
    answer(slcan, "\r");
    if (slcan->length == 0u) {
        return 0;
    }
    switch (slcan->line[0]) {
        case 'S':
            return choose(slcan, '8', true);
        case 'Y':
            return choose(slcan, '5', true);
        case 'Z':
            return choose(slcan, '0', false);
        case 's':
            return set_bit_timing(slcan);
        default:
            break;
    }
    if (slcan->length == 1u) {
        return command(slcan);
    }
    if (!slcan->open || slcan->listen_only || !read_frame(slcan->line, slcan->length, frame)) {
        return CCGEN_ERROR_FORMAT;
    }
    return 1;
}

int ccgen_slcan_init(ccgen_slcan_t *const slcan) {
    const ccgen_slcan_t closed = CCGEN_ZERO;
    if (slcan == NULL) {
        return CCGEN_ERROR_ARGUMENT;
    }
    *slcan = closed;
    return CCGEN_OK;
}

int ccgen_slcan_feed(ccgen_slcan_t *const slcan, const uint8_t byte, ccgen_frame_t *const frame) {
    if ((slcan == NULL) || (frame == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    slcan->reply_length = 0;
    if (byte == (uint8_t)'\n') {
        return 0;
    }
    if (byte != (uint8_t)'\r') {
        if (slcan->length < CCGEN_SLCAN_LINE_MAX) {
            slcan->line[slcan->length] = byte;
            slcan->length = (uint8_t)(slcan->length + 1u);
        } else {
            slcan->overlong = true;
        }
        return 0;
    }
    const int result = slcan->overlong ? CCGEN_ERROR_FORMAT : carry_out(slcan, frame);
    if (result < 0) {
        answer(slcan, "\a");
    }
    slcan->length = 0;
    slcan->overlong = false;
    return result;
}

/** \return the code from 0 to F of a number of bytes, LENGTH_CODES when there is none. */
static uint8_t code_of_length(const ccgen_frame_t *const frame) {
    const uint8_t codes = frame->fd ? LENGTH_CODES : (CLASSIC_LENGTH_MAX + 1u);
    for (uint8_t code = 0; code < codes; ++code) {
        if (length_of_code(code) == frame->length) {
            return code;
        }
    }
    return LENGTH_CODES;
}

int ccgen_slcan_encode(const ccgen_frame_t *const frame, uint8_t *const buffer,
                       const size_t capacity) {
    if ((frame == NULL) || (buffer == NULL)) {
        return CCGEN_ERROR_ARGUMENT;
    }
    const uint8_t code = code_of_length(frame);
    if ((code == LENGTH_CODES) || (frame->remote && frame->fd)) {
        return CCGEN_ERROR_FORMAT;
    }
    const uint8_t bytes = frame->remote ? 0u : frame->length;
    const size_t length = 1u + (size_t)id_digits(frame) + 1u + 2u * (size_t)bytes + 1u;
    if (!id_exists(frame) || (capacity < length)) {
        return CCGEN_ERROR_RANGE;
    }
    buffer[0] = kind_character(frame);
    uint8_t *text = write_number(&buffer[1], frame->id, id_digits(frame));
    text = write_number(text, code, 1);
    for (uint8_t i = 0; i < bytes; ++i) {
        text = write_number(text, frame->data[i], 2);
    }
    *text = (uint8_t)'\r';
    return (int)length;
}
