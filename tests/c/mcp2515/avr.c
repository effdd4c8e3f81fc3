/*
 * An ATmega1284P's firmware in simavr, with the modelled chip on its SPI (CS on PB4, INT on PD2) and
 * a script on standard input. What the chip sends is printed, then the firmware's counters, read
 * from its RAM at an address.
 *
 *     avr FIRMWARE ADDRESS OSCILLATOR BIT_RATE
 */
#include <simavr/avr_ioport.h>
#include <simavr/avr_spi.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <stdio.h>
#include <stdlib.h>
#include <fcntl.h>
#include <unistd.h>

#include "bus.h"

#define HERTZ 16000000u
#define CYCLES_BETWEEN_LOOKS 32
#define CYCLES_OF_BYTE 16
#define SPDR 0x4E
#define EIFR 0x3C
#define EIMSK 0x3D

static avr_t *avr;
static bus_t *bus;
static avr_irq_t *spi_input, *int_pin;
static uint8_t sent;
static bool selected, low, going = true;

/* An edge that is lost leaves the level as it is and no flag behind. */
static void show_int(void) {
    const bool is_low = chip_interrupts(bus_chip(bus));
    if (is_low == low) {
        return;
    }
    low = is_low;
    const uint8_t mask = avr->data[EIMSK];
    const bool deaf = is_low && bus_is_deaf(bus);
    if (deaf) {
        avr->data[EIMSK] = 0;
    }
    avr_raise_irq(int_pin, !is_low);
    if (deaf) {
        avr->data[EIFR] = 0;
        avr->data[EIMSK] = mask;
    }
}

static void look(void) {
    going = bus_advance(bus, avr->cycle * 1000u / (HERTZ / 1000000u));
    show_int();
}

static avr_cycle_count_t on_exchanged(avr_t *unused, avr_cycle_count_t when, void *none) {
    (void)unused;
    (void)when;
    (void)none;
    look();
    avr_raise_irq(spi_input, selected ? chip_exchange(bus_chip(bus), sent) : 0xFF);
    show_int();
    return 0;
}

/* simavr's own SPI takes 100 us a byte, whatever its clock; half the processor's is set. */
static void on_byte(avr_t *unused, avr_io_addr_t address, uint8_t byte, void *none) {
    (void)unused;
    (void)address;
    (void)none;
    sent = byte;
    avr_cycle_timer_register(avr, CYCLES_OF_BYTE, on_exchanged, NULL);
}

static void on_select(struct avr_irq_t *irq, uint32_t level, void *unused) {
    (void)irq;
    (void)unused;
    if (!level && !selected) {
        chip_select(bus_chip(bus));
    } else if (level && selected) {
        chip_deselect(bus_chip(bus));
        show_int();
    }
    selected = !level;
}

static void on_sleep(avr_t *unused, avr_cycle_count_t cycles) {
    (void)unused;
    (void)cycles; /* no nap */
}

/* simavr says on standard output what it loads. */
static avr_t *load(const char *path) {
    elf_firmware_t firmware = {0};
    const int output = dup(1), nowhere = open("/dev/null", O_WRONLY);
    dup2(nowhere, 1);
    if (elf_read_firmware(path, &firmware) != 0) {
        return NULL;
    }
    firmware.frequency = HERTZ;
    avr_t *made = avr_make_mcu_by_name("atmega1284p");
    avr_init(made);
    avr_load_firmware(made, &firmware);
    fflush(stdout);
    dup2(output, 1);
    return made;
}

int main(int argc, char **argv) {
    if (argc != 5 || (avr = load(argv[1])) == NULL) {
        fprintf(stderr, "usage: avr FIRMWARE ADDRESS OSCILLATOR BIT_RATE\n");
        return 2;
    }
    const unsigned address = (unsigned)strtoul(argv[2], NULL, 16) & 0xFFFFu;
    avr->sleep = on_sleep;
    bus = bus_new((uint32_t)strtoul(argv[3], NULL, 10), (uint32_t)strtoul(argv[4], NULL, 10));
    spi_input = avr_io_getirq(avr, AVR_IOCTL_SPI_GETIRQ(0), SPI_IRQ_INPUT);
    int_pin = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), 2);
    avr_register_io_write(avr, SPDR, on_byte, NULL);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('B'), 4), on_select, NULL);
    avr_raise_irq(int_pin, 1);
    avr_cycle_count_t next = 0;
    int state = cpu_Running;
    while (going && state != cpu_Done && state != cpu_Crashed) {
        state = avr_run(avr);
        if (avr->cycle >= next) {
            look();
            next = avr->cycle + CYCLES_BETWEEN_LOOKS;
        }
    }
    printf("started %d nested 0 clocks %u\ncounters", state, chip_bit_clocks(bus_chip(bus)));
    for (unsigned i = 0; i < 6; ++i) {
        const uint8_t *at = &avr->data[address + 4 * i];
        printf(" %lu", (unsigned long)(at[0] | at[1] << 8 | at[2] << 16 | (uint32_t)at[3] << 24));
    }
    printf("\n");
    bus_end(bus);
    return 0;
}
