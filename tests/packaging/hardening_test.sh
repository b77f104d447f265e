#!/usr/bin/env bash
# The protections of cmake/Hardening.cmake as they ended up in a program. Code 77: skipped. Usage: hardening_test.sh PROGRAM...
set -euo pipefail
command -v readelf >/dev/null || { echo "LOUD: SKIPPED: no readelf here (apt-get install binutils)" >&2; exit 77; }
# Counts to the end: a grep that stops at its first find would end what writes to it.
count() { grep -Ec "$1" || true; }
for program in "$@"; do
  lacks() { echo "$program: $1" >&2; exit 1; }
  [ "$(readelf -h "$program" | count 'Type: *DYN')" -gt 0 ] || lacks "not position independent"
  [ "$(readelf -lW "$program" | count GNU_RELRO)" -gt 0 ] || lacks "tables stay writable (relro)"
  [ "$(readelf -dW "$program" | count 'BIND_NOW|Flags:.* NOW')" -gt 0 ] || lacks "functions are bound late (now)"
  [ "$(readelf -lW "$program" | count 'GNU_STACK.*RWE')" -eq 0 ] || lacks "the stack is executable"
  [ "$(readelf --dyn-syms -W "$program" | count __stack_chk_fail)" -gt 0 ] || lacks "no guarded stack frame"
  [ "$(readelf --dyn-syms -W "$program" | grep -v __stack_chk_fail | count '__[a-z]+_chk@')" -gt 0 ] ||
    lacks "no checked call of the C library (FORTIFY)"
  if [ "$(uname -m)" = x86_64 ]; then  # some stand in what the compiler itself links
    [ "$(objdump -d --no-show-raw-insn -j .text "$program" | count endbr64)" -gt 100 ] || lacks "no marked targets (CET)"
  fi
  echo "$program: position independent, relro, bound at the start, guarded, checked, marked"
done
