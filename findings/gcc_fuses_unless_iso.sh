#!/usr/bin/env bash
# GCC: -std=c11 and -std=gnu11 round differently on 64-bit ARM, and the standard's own pragma is ignored.
#
# One would guess: -std=c11 only hides extensions; a product stored in a variable is rounded before it is added to
#   something; #pragma STDC FP_CONTRACT OFF, which C11 has for this, forbids anything else.
# What happens: without a -std option GCC turns "double p = a * b; return p + c;" into one fused instruction at -O2, with a
#   single rounding, although the product has a statement of its own. With -std=c11 or -std=c17 it does not. The
#   pragma changes nothing (a warning says so, with -Wall only). -ffp-contract=off is what works.
# Why it matters: a controller that was checked bit by bit on a PC, where these instructions need an option, differs on
#   the robot's ARM computer in the last digits, and whether it does hangs on the language option of somebody
#   else's build. Searches and recorded runs then end elsewhere.
# Seen with: gcc-12-aarch64-linux-gnu 12.2.0 (Debian 12).
# Source: https://github.com/KhronosGroup/OpenCL-CTS/issues/1794 (results differ by processor and compiler) and
#   https://github.com/llvm/llvm-test-suite/pull/440 (GCC does not support the pragma).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq gcc-12-aarch64-linux-gnu cpp-12-aarch64-linux-gnu
for package in *.deb; do dpkg-deb -x "$package" .; done
gcc="$work/usr/bin/aarch64-linux-gnu-gcc-12"

echo 'double sum(double a, double b, double c) { double p = a * b; return p + c; }' > plain.c
{ echo '#pragma STDC FP_CONTRACT OFF'; cat plain.c; } > pragma.c

# Print and check how many fused instructions come out.
fused() { # EXPECTED FILE OPTION...
  local expected=$1 file=$2 count
  shift 2
  "$gcc" -O2 "$@" -S -o out.s "$file" 2> messages.txt
  count=$(grep -cE '\bfn?m(add|sub)\b' out.s || true)
  printf '  %-9s -O2 %-18s fused instructions: %s, warnings: %s\n' \
    "$file" "$*" "$count" "$(grep -c warning: messages.txt || true)"
  [ "$count" -eq "$expected" ]
}

"$gcc" --version | head -n 1
fused 1 plain.c
fused 1 plain.c -std=gnu11
fused 0 plain.c -std=c11
fused 0 plain.c -std=c17
fused 1 pragma.c
fused 1 pragma.c -Wall
fused 0 pragma.c -ffp-contract=off
