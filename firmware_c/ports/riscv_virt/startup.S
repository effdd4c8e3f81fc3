/*
 * From reset to main() on RISC-V: stack, global pointer, traps, cleared data.
 */
    .option arch, +zicsr

    /* Outside of .text: with -ffunction-sections a function has a section of its name there. */
    .section .startup, "ax"
    .globl _start
_start:
    .option push
    .option norelax
    la gp, global_pointer
    .option pop
    la sp, stack_top
    la t0, trap_handler
    csrw mtvec, t0

    la t0, bss_start
    la t1, bss_end
1:  bgeu t0, t1, 2f
    sw zero, 0(t0)
    addi t0, t0, 4
    j 1b

2:  call main
    call board_end
