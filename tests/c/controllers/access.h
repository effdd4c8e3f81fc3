/**
 * \file access.h
 * \brief Registers are a model's: included before a port's own code.
 */
#ifndef ACCESS_H
#define ACCESS_H

#include <stdint.h>

uint32_t fake_read(volatile uint32_t *address);
void fake_write(volatile uint32_t *address, uint32_t value);

#define CAN_PORT_READ(address) fake_read(address)
#define CAN_PORT_WRITE(address, value) fake_write((address), (value))

#endif /* ACCESS_H */
