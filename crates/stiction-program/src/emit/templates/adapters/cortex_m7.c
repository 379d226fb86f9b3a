/* Start of a bare Cortex-M7 in QEMU (machine mps2-an500); the C library talks to the host by
   semihosting. On a board, its own startup code takes this place. */
#include <stdint.h>

void Reset(void);
extern void _start(void);

static void stop(void)
{
    for (;;) {
    }
}

/* Coprocessor access control register. */
#define CPACR (*(volatile uint32_t *)0xE000ED88u)

__attribute__((used)) void Reset(void)
{
    /* Full access to the floating-point unit. */
    CPACR |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    _start();
    stop();
}

typedef void (*handler)(void);

/* Top of the stack, then the handlers of reset and of the exceptions. */
__attribute__((section(".vectors"), used)) static const handler VECTORS[] = {
    (handler)0x20400000u, Reset, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop, stop
};
