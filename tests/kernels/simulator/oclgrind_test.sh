#!/bin/sh
# Every kernel on Oclgrind's simulated device: no invalid access, no data race, no use of uninitialised memory, no misuse of
# the OpenCL calls.
if ! command -v oclgrind > /dev/null; then
  echo "oclgrind is not installed (Debian: oclgrind); nothing was checked"
  exit 0
fi
# Oclgrind is preloaded before a sanitizer's runtime, and leaks.
export ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0
log="${TEST_TMPDIR:-/tmp}/oclgrind.log"
: > "$log"
out=$(oclgrind --data-races --uninitialized --check-api --log "$log" "$1" Oclgrind)
code=$?
echo "$out"
cat "$log"
if [ $code -ne 0 ]; then
  echo "the program failed with exit code $code"
  exit 1
fi
case "$out" in
  *Oclgrind*) ;;
  *) echo "the simulated device was never used"; exit 1 ;;
esac
if [ -s "$log" ]; then
  echo "Oclgrind had something to say"
  exit 1
fi
