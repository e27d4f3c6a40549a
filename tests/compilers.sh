#!/usr/bin/env bash
# The headers under other compilers, standards and options: what must work and what must be refused.
# usage: tests/compilers.sh libnfopidn_batch.a
set -euo pipefail
library=$(realpath "$1")
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

# The host's headers, each once: wide_loops.hpp is a part of wide.hpp. Where 32 bits or a standard
# warn, a user's -Werror does not build.
host() { # compiler and options
  find cpp/include/nfopidn -name '*.hpp' ! -name wide_loops.hpp -printf '#include "nfopidn/%P"\n' | sort |
    "$@" "${warnings[@]}" -Icpp/include -isystem /usr/include/eigen3 -fsyntax-only -x c++ - ||
    fail "$*, the host's headers"
}
# Debian has <asm/errno.h> where 64 bits look for it.
bits32=(g++-12 -m32 -msse2 -mfpmath=sse -idirafter /usr/include/x86_64-linux-gnu)
host "${bits32[@]}" -std=c++17
host clang++ -std=c++20
host g++-11 -std=c++2b
python=.venv/bin/python
[[ -x $python ]] || python=python3
read -ra pybind <<<"$("$python" -m pybind11 --includes)"
g++ -std=c++2b "${warnings[@]}" -Icpp/include -isystem /usr/include/eigen3 "${pybind[@]/#-I/-isystem}" \
  -fvisibility=hidden -fsyntax-only cpp/src/bindings/fractional.cpp || fail "the bindings in C++23"
echo "compilers: the host's headers warn in no standard, with GCC 11 and 12, Clang and in 32 bits"

# The benchmarks are built by ./dev bench alone; that they still compile is told here.
for source in bench/*.cpp; do
  if grep -q '<benchmark/' "$source" && [[ ! -e /usr/include/benchmark/benchmark.h ]]; then
    echo "compilers: $source is not compiled, as Google Benchmark is not installed"
    continue
  fi
  g++ -std=c++17 "${warnings[@]}" -Icpp/include -isystem /usr/include/eigen3 -fsyntax-only \
    "$source" || fail "$source"
done
echo "compilers: the benchmarks compile"

# A search ends at the same bits whatever the processor and Eigen's vectors: here, without Eigen's
# vectors, in 32 bits, and on aarch64 in the emulator, where lanes are the generic unit.
googletest=/usr/src/googletest/googletest
common=(-std=c++17 -O1 -ffp-contract=off -Wall -Wextra -Werror -pthread -Icpp/include -Icpp/src -Itests/cpp
  -isystem /usr/include/eigen3 -isystem "$googletest/include"
  -DNFOPIDN_GOLDEN="\"$PWD/tests/golden\"")
generic=(cpp/src/batch/dispatch.cpp cpp/src/batch/kernel_generic.cpp)
probe() { # a name, compiler, options and what to link
  local out=$folder/probe_$1
  shift
  "${@:1:1}" "${common[@]}" tests/cpp/batch_probe.cpp "${@:2}" -o "$out"
}
bits() { # a name, and a program to run it by
  "${@:2}" "$folder/probe_$1" 3000 | cut -d' ' -f2-
}

probe here g++ "$library"
probe plain_eigen g++ -DEIGEN_DONT_VECTORIZE "$library"
probe bits32 "${bits32[@]}" "${generic[@]}"
probe aarch64 aarch64-linux-gnu-g++ -static "${generic[@]}"
here=$(bits here)
for other in "plain_eigen" "bits32" "aarch64 qemu-aarch64"; do
  read -ra words <<<"$other"
  [[ $(bits "${words[@]}") == "$here" ]] || fail "$other: the search ends elsewhere"
done
echo "compilers: a search ends at the same bits on x86-64, in 32 bits and on aarch64"

aarch64-linux-gnu-g++ -static "${common[@]}" -I"$googletest" "$googletest/src/gtest-all.cc" \
  "$googletest/src/gtest_main.cc" tests/cpp/tuning/test_lanes.cpp tests/cpp/tuning/test_batch.cpp \
  tests/cpp/firmware/test_self_test.cpp "${generic[@]}" -o "$folder/tests_aarch64"
qemu-aarch64 "$folder/tests_aarch64" --gtest_brief=1 | tail -1

# Eigen from 3.4 on, whatever its version file makes of 5.0.
eigen() { # version
  mkdir -p "$folder/eigen"
  echo "add_library(Eigen3::Eigen INTERFACE IMPORTED)" >"$folder/eigen/Eigen3Config.cmake"
  printf '%s\n' "set(PACKAGE_VERSION $1)" \
    "string(COMPARE EQUAL \"\${PACKAGE_FIND_VERSION_MAJOR}\" \"\" PACKAGE_VERSION_COMPATIBLE)" \
    >"$folder/eigen/Eigen3ConfigVersion.cmake"
  cmake -S . -B "$folder/with_eigen" -G Ninja --fresh -DEigen3_DIR="$PWD/$folder/eigen" \
    -DNFOPIDN_EXECUTABLE=OFF -DNFOPIDN_BATCH=OFF -DNFOPIDN_JSON=OFF 2>&1
}
grep -q "Generating done" <<<"$(eigen 5.0.1)" || fail "Eigen 5.0.1 is refused"
grep -q "needs 3.4" <<<"$(eigen 3.3.9)" || fail "Eigen 3.3.9 is not refused"
echo "compilers: Eigen 3.4 and newer"
