#!/usr/bin/env bash
# What the script `run` does, one test after the other.
failed=0
for test in setup demo images test_count; do
  mkdir "$TEST_TMPDIR/$test"
  TEST_TMPDIR=$TEST_TMPDIR/$test bash "tests/run/${test}_test.sh" || { echo "${test}_test failed" >&2 && failed=1; }
done
exit $failed
