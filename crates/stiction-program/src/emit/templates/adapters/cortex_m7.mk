
# Self-test on a bare Cortex-M7 in QEMU.
ARM_CC ?= arm-none-eabi-gcc
ARM_CFLAGS ?= -O2 -std=c99 -Wall -Wextra -Wpedantic -Wconversion -mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16

test-cortex-m7: selftest_m7.elf
	qemu-system-arm -M mps2-an500 -display none -monitor none -serial none \
	    -semihosting-config enable=on,target=native,arg=selftest,arg=vectors.csv -kernel selftest_m7.elf

selftest_m7.elf: selftest.c @NAME@.c @NAME@.h cortex_m7.c cortex_m7.ld
	$(ARM_CC) $(ARM_CFLAGS) --specs=rdimon.specs -T cortex_m7.ld -o selftest_m7.elf \
	    cortex_m7.c selftest.c @NAME@.c -lm

.PHONY: test-cortex-m7
