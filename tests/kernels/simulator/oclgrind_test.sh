#!/bin/sh
# Every kernel on Oclgrind's simulated device: no invalid access, no data race, no misuse of the OpenCL calls. Its check for
# uninitialised memory is left out: version 21.10 reports memory that the kernels fill with zeros before they read it.
. tests/shell/skip.sh
if ! command -v oclgrind > /dev/null; then
  # Debian 12 has it, and ./run setup installs it for the tests there.
  if grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; then
    echo "oclgrind is not installed; ./run setup does that"
    exit 1
  fi
  skip oclgrind_test "there is no oclgrind here (Debian 12 has it); nothing was checked"
fi
# Oclgrind is preloaded before a sanitizer's runtime, and leaks.
export ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0
# Reports go to the standard error, where the program writes only what fails; with --log they are lost.
reports="${TEST_TMPDIR:-/tmp}/oclgrind.txt"
out=$(EGOSIEVE_DEVICE=Oclgrind oclgrind --data-races --check-api --max-errors 20 "$1" 2> "$reports")
code=$?
echo "$out"
cat "$reports"
if [ $code -ne 0 ]; then
  echo "the program failed with exit code $code"
  exit 1
fi
case "$out" in
  *Oclgrind*"tiles in local memory"*) ;;
  *) echo "the simulated device was not used for every shape"; exit 1 ;;
esac
if [ -s "$reports" ]; then
  echo "Oclgrind had something to say"
  exit 1
fi
