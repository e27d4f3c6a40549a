#!/usr/bin/env bash
# The units per instruction set must not share functions, with each other or with what is compiled for
# the plain architecture: the linker would keep one of them, for all processors. And a processor without the wide instructions must get the narrow ones.
# usage: tests/batch_units.sh libnfopidn_batch.a nfopidn_batch_probe
set -euo pipefail
library=$1 probe=$2

shared=$(nm -A --defined-only "$library" | awk '$2 ~ /^[WVuw]$/ || $3 ~ /^[WVuw]$/ {
    split($1, place, ":"); print $NF, place[2] }' | sort -u | awk '
    { units[$1]++; if ($2 ~ /^kernel_/) kernels[$1]++ }
    END { for (name in kernels) if (units[name] > 1) print name }')
if [[ -n $shared ]]; then
  echo "defined in more than one unit:" >&2
  c++filt <<<"$shared" >&2
  exit 1
fi
echo "no weak symbol of an instruction set's unit in another one"

[[ $(uname -m) == x86_64 ]] || exit 0
native=$("$probe")
echo "here: $native"
for processor in Nehalem Haswell; do
  emulated=$(qemu-x86_64 -cpu "$processor" "$probe" 2>/dev/null)
  echo "$processor: $emulated"
  case $processor in
    Nehalem) [[ $emulated == sse2\ * ]] ;;
    Haswell) [[ $emulated == avx2\ * ]] ;;
  esac || { echo "$processor got the wrong unit" >&2; exit 1; }
  [[ ${emulated#* } == "${native#* }" ]] || { echo "the costs differ" >&2; exit 1; }
done
