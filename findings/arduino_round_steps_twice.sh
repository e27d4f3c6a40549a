#!/usr/bin/env bash
# Arduino: round(step(error)) runs the controller twice, and round(x) / 10 is an integer division.
#
# One would guess: round() is the function of <math.h>, as Arduino.h includes that header: one evaluation, a double.
# What happens: Arduino.h for AVR boards defines round as a macro that names its argument three times, of which two
#   are evaluated, and that yields a long. A controller called inside it takes two steps a sample: its
#   integrator and its history run at double speed, the output of the first step is only compared with zero. And
#   round(15.0) / 10 is 1.
# Why it matters: PWM counts are made in just this way: analogWrite(pin, round(255 * step(...))).
# Seen with: arduino-core-avr 1.8.7 (Debian 12), the macro taken from its header and compiled for this machine.
# Source: https://github.com/arduino/ArduinoCore-API/issues/76 (the macro yields a long) and
#   https://github.com/arduino/Arduino/issues/6098 (its argument is evaluated more than once).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq arduino-core-avr
dpkg-deb -x arduino-core-avr_*.deb .
header=usr/share/arduino/hardware/arduino/avr/cores/arduino/Arduino.h
echo "version: $(dpkg-deb -f arduino-core-avr_*.deb Version)"
grep -q 'include <math.h>' "$header"
grep '^#define round(' "$header" > round.h
echo "in Arduino.h: $(cat round.h)"

cat > sketch.cpp <<'CODE'
#include <cmath>
#include <cstdio>

static int steps = 0;

static double step(double error) {
  static double integral = 0.0;
  ++steps;
  integral += error;
  return integral;
}

int main() {
  long total = 0;
  for (int sample = 0; sample < 10; ++sample) total = round(step(1.0));
  std::printf("10 samples: %d steps, last output %ld\n", steps, total);
  std::printf("round(15.0) / 10 = %g\n", static_cast<double>(round(15.0) / 10));
}
CODE
c++ -O1 sketch.cpp -o function
c++ -O1 -include cmath -include cstdio -include ./round.h sketch.cpp -o macro
echo "with the function of <math.h>:"; ./function | tee function.txt
echo "with the macro of Arduino.h:"; ./macro | tee macro.txt

printf '%s\n' "10 samples: 10 steps, last output 10" "round(15.0) / 10 = 1.5" | cmp - function.txt
printf '%s\n' "10 samples: 20 steps, last output 20" "round(15.0) / 10 = 1" | cmp - macro.txt
