#!/usr/bin/env bash
# The headers under other compilers, standards and options: what must work and what must be refused.
# usage: tests/compilers.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
folder=build/compilers
mkdir -p "$folder"
warnings=(-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror)

fail() { echo "tests/compilers.sh: $*" >&2; exit 1; }

# What the program prints for float and double must begin with a verdict from the list, and the
# torques must be right.
runs() { # verdicts, compiler and options
  local verdicts=$1 words
  shift
  "$@" -std=c++17 "${warnings[@]}" -Icpp/include tests/compilers/self_test.cpp -o "$folder/self_test"
  words=$("$folder/self_test")
  [[ $words =~ ^[$verdicts]\ 0.576\ 0.000\ [$verdicts]\ 0.576\ 0.000\ $ ]] || fail "$*: $words"
}

refused() { # words of the message, compiler and options
  local message=$1 said
  shift
  if said=$("$@" -Icpp/include -fsyntax-only -x c++ cpp/include/nfopidn/firmware.hpp 2>&1); then
    fail "$*: not refused"
  fi
  grep -q "error.*$message" <<<"$said" || fail "$*: $said"
}

# The option that a compiler reports is refused; under one that it does not report, the torques are
# right, if not to the last bit.
runs 0 g++ -O2
runs 0 clang++ -O2 -ffp-contract=off
runs 0 g++-11 -O2
runs 03 g++ -O2 -mfma -ffp-contract=fast
runs 03 clang++ -O2 -funsafe-math-optimizations
runs 03 clang++ -O2 -fassociative-math -fno-signed-zeros -fno-trapping-math
runs 03 g++-11 -O3 -funsafe-math-optimizations
runs 03 g++-11 -O3 -fassociative-math -fno-signed-zeros -fno-trapping-math
runs 0 g++-12 -O2 -m32 -msse2 -mfpmath=sse
for compiler in g++ clang++; do
  refused "without -ffast-math" "$compiler" -std=c++17 -ffast-math
  refused "without -ffast-math" "$compiler" -std=c++17 -Ofast
  refused "looks for NaN" "$compiler" -std=c++17 -ffinite-math-only
done
refused "without -ffast-math" g++ -std=c++17 -funsafe-math-optimizations
refused "without -ffast-math" g++ -std=c++17 -fassociative-math -fno-signed-zeros -fno-trapping-math
refused "excess precision" g++-12 -std=c++17 -m32 -mfpmath=387
echo "compilers: every option works or is refused"

# Every standard; without the C++ standard library, as toolchains for small processors are; and after
# the Arduino core, which takes common words as macros. firmware.hpp and every header it has, alone.
zone=$(g++ -std=c++17 -Icpp/include -MM cpp/include/nfopidn/firmware.hpp | grep -o 'nfopidn/[a-z_0-9/]*\.hpp')
for compiler in g++ g++-11 clang++; do
  for standard in 17 20 2b; do
    for header in $zone; do echo "#include \"$header\""; done |
      "$compiler" -std=c++$standard -nostdinc++ "${warnings[@]}" -include tests/compilers/arduino.hpp \
        -Icpp/include -fsyntax-only -x c++ - || fail "$compiler, C++$standard, firmware zone"
  done
done
for header in $zone; do
  g++ -std=c++17 -nostdinc++ "${warnings[@]}" -Icpp/include -fsyntax-only -x c++ -include "$header" \
    /dev/null || fail "$header alone"
done
refused "needs C++17" g++ -std=c++14
refused "needs C++17" clang++ -std=c++14
echo "compilers: the firmware zone needs a compiler and <stdint.h>, in C++17, 20 and 23"
