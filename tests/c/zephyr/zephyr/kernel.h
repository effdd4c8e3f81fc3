/** Stand-in for Zephyr's header: time and semaphores, as far as examples use them. */
#ifndef FAKE_ZEPHYR_KERNEL_H
#define FAKE_ZEPHYR_KERNEL_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    int64_t ms; /* -1: for ever */
} k_timeout_t;

#define K_NO_WAIT ((k_timeout_t){0})
#define K_MSEC(time) ((k_timeout_t){time})
#define K_FOREVER ((k_timeout_t){-1})

struct k_sem {
    unsigned count;
    unsigned limit;
};

#define K_SEM_DEFINE(name, initial, most) struct k_sem name = {initial, most}

int k_sem_take(struct k_sem *sem, k_timeout_t timeout);
void k_sem_give(struct k_sem *sem);

int64_t k_uptime_ticks(void);
uint64_t k_ticks_to_us_floor64(uint64_t ticks);

#endif
