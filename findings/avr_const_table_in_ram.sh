#!/usr/bin/env bash
# avr-gcc: a const table of reference values takes RAM, and its doubles are floats.
#
# One would guess: "static const double reference[300]" lies in the 32 KB of flash of an Arduino Uno, like on every
#   other microcontroller, with 8 bytes an item.
# What happens: the AVR reads flash by other instructions than RAM, so the compiler keeps constants in RAM: the
#   start-up code copies them there from flash. 300 values take 1200 of the 2048 bytes, 600 overflow, which the linker only notices
#   since they are more than all RAM; 480 link without a word and leave 122 bytes for the stack. PROGMEM
#   keeps the table in flash, and each read then needs pgm_read_float. double has 4 bytes: 16777217.0 is 16777216.
# Why it matters: the reference of a path, a table of weights and a filter's taps are such tables. A stack that grows
#   into them changes torques without a fault; sums of time in double stop growing as a float's do.
# Seen with: gcc-avr 5.4.0 and avr-libc 2.0.0 (Debian 12), for the ATmega328P.
# Source: https://www.arduino.cc/en/Reference/PROGMEM and
#   https://manpages.ubuntu.com/manpages/noble/man3/pgmspace.3avr.html (constants are copied to RAM at start-up).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq gcc-avr avr-libc binutils-avr
for package in *.deb; do dpkg-deb -x "$package" .; done
export PATH="$work/usr/bin:$PATH"
avr-gcc --version | head -n 1

# Print the bytes of RAM that a program with a table of so many values takes before it starts.
ram() { # COUNT QUALIFIER READ
  cat > table.c <<CODE
#include <avr/pgmspace.h>
volatile int i;
volatile double out;
static const double table[$1] $2 = {1.0, 2.0, 3.0, [$1 - 1] = 4.0};
_Static_assert(sizeof(double) == 4, "double has another size now");
int main(void) { for (;;) out = $3; }
CODE
  avr-gcc -mmcu=atmega328p -Os table.c -o table.elf || return 1
  avr-size -A table.elf | awk '/^\.(data|bss)/ { bytes += $2 } END { print bytes }'
}

plain=$(ram 300 "" "table[i]")
tight=$(ram 480 "" "table[i]")
flash=$(ram 480 PROGMEM "pgm_read_float(&table[i])")
echo "RAM of 2048 bytes taken: 300 values $plain, 480 values $tight, 480 values in PROGMEM $flash"
if ram 600 "" "table[i]" 2> linker.txt; then echo "600 values link now"; exit 1; fi
echo "600 values: $(grep -m 1 -o 'section .*region.*' linker.txt)"
[ "$plain" -ge 1200 ] && [ "$tight" -ge 1920 ] && [ "$flash" -lt 20 ]
