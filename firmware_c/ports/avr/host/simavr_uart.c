/**
 * \file simavr_uart.c
 * \brief Runs an ATmega's firmware in simavr with USART 0 on standard input and output.
 *
 * For the host: cc simavr_uart.c -lsimavr. Usage: simavr_uart MCU HERTZ FIRMWARE.
 * A busy processor runs as fast as the host lets it; a sleeping one waits in real time. Ends with
 * the value of the register GPIOR0 when the firmware sleeps with interrupts off, with 0 when the
 * line is closed, with 3 when the processor crashed.
 */
#define _POSIX_C_SOURCE 200809L

#include <poll.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define GPIOR0 0x3E
#define CRASHED 3
#define CYCLES_BETWEEN_LOOKS 2000

/** Both directions of the line. */
typedef struct {
    avr_irq_t *input;
    int output;
    bool ready;  /**< the USART takes bytes */
    bool ended;  /**< nothing more comes in */
    bool closed; /**< the other end has closed the line */
    uint8_t in[512];
    size_t in_next, in_end;
    uint8_t out[512];
    size_t out_end;
} line_t;

static line_t line;

static void flush(void) {
    size_t written = 0;
    while (written < line.out_end) {
        const ssize_t n = write(line.output, line.out + written, line.out_end - written);
        if (n < 0) {
            line.closed = true;
            break;
        }
        written += (size_t)n;
    }
    line.out_end = 0;
}

static void on_output(struct avr_irq_t *irq, uint32_t byte, void *unused) {
    (void)irq;
    (void)unused;
    line.out[line.out_end++] = (uint8_t)byte;
    if (line.out_end == sizeof line.out) {
        flush();
    }
}

static void on_ready(struct avr_irq_t *irq, uint32_t value, void *unused) {
    (void)irq;
    (void)value;
    (void)unused;
    line.ready = true;
}

static void on_full(struct avr_irq_t *irq, uint32_t value, void *unused) {
    (void)irq;
    (void)value;
    (void)unused;
    line.ready = false;
}

/** Reads what there is to read; waits for it up to `wait_us`. */
static void receive(const uint32_t wait_us) {
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
    if (poll(&input, line.ended ? 0 : 1, (int)((wait_us + 999) / 1000)) <= 0) {
        return;
    }
    const ssize_t n = read(STDIN_FILENO, line.in, sizeof line.in);
    line.ended = n == 0; /* a file, or /dev/null */
    line.closed = n < 0; /* a terminal whose other end is gone */
    line.in_next = 0;
    line.in_end = n > 0 ? (size_t)n : 0;
}

/** Hands over what is there, as far as the USART takes it; waits for input up to `wait_us`. */
static void look(const uint32_t wait_us) {
    flush();
    if (line.in_next == line.in_end) {
        receive(wait_us);
    }
    while (line.ready && line.in_next < line.in_end) {
        avr_raise_irq(line.input, line.in[line.in_next++]);
    }
}

static void on_sleep(avr_t *avr, avr_cycle_count_t cycles) {
    look(avr_pending_sleep_usec(avr, cycles));
}

static void connect_usart(avr_t *const avr) {
    uint32_t flags = 0; /* no echo on the console, no naps while the firmware polls */
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    line.input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT),
                            on_output, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON),
                            on_ready, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF),
                            on_full, NULL);
}

static avr_t *load(const char *const mcu, const char *const hertz, const char *const path) {
    elf_firmware_t firmware = {0};
    avr_t *const avr = avr_make_mcu_by_name(mcu);
    if (avr == NULL || elf_read_firmware(path, &firmware) != 0) {
        return NULL;
    }
    firmware.frequency = (uint32_t)strtoul(hertz, NULL, 10);
    avr_init(avr);
    avr_load_firmware(avr, &firmware);
    return avr;
}

/** simavr talks on standard output; that belongs to the line, so it goes to standard error. */
static void keep_output(void) {
    line.output = dup(STDOUT_FILENO);
    dup2(STDERR_FILENO, STDOUT_FILENO);
}

int main(int argc, char **argv) {
    keep_output();
    avr_t *const avr = argc == 4 ? load(argv[1], argv[2], argv[3]) : NULL;
    if (avr == NULL) {
        fprintf(stderr, "usage: simavr_uart MCU HERTZ FIRMWARE\n");
        return 2;
    }
    avr->sleep = on_sleep;
    connect_usart(avr);
    avr_cycle_count_t next_look = 0;
    int state = cpu_Running;
    while (state != cpu_Done && state != cpu_Crashed && !line.closed) {
        state = avr_run(avr);
        if (avr->cycle >= next_look) {
            look(0);
            next_look = avr->cycle + CYCLES_BETWEEN_LOOKS;
        }
    }
    flush();
    return state == cpu_Crashed ? CRASHED : state == cpu_Done ? avr->data[GPIOR0] : 0;
}
