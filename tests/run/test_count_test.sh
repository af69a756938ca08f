#!/usr/bin/env bash
# What `./run test` counts, and when sanitizers and clang-tidy run; bazel, git and clang-tidy are
# stand-ins.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

tree=$TEST_TMPDIR/tree
mkdir -p "$tree"/{tools_on_path,bazel-testlogs/tests/kernels/a_test}
cp run "$tree/run"
mkdir -p "$tree/tests/run"
cp tests/run/suite.py "$tree/tests/run"
for name in bash cat dirname; do
  ln -s "$(command -v "$name")" "$tree/tools_on_path/$name"
done
cat >"$tree/bazel-testlogs/tests/kernels/a_test/test.xml" <<'END'
<testsuites tests="7" failures="0" errors="0">
<testcase name="x" result="skipped"/>
</testsuites>
END
bazel_says() {
  printf '#!/bin/bash\necho "$*" >>%s/calls\ncat <<END\n%s\nEND\n' "$tree" "$1" >"$tree/tools_on_path/bazel"
  chmod +x "$tree/tools_on_path/bazel"
}
run_test() {
  : >"$tree/calls"
  (cd "$tree" && PATH=$tree/tools_on_path bash ./run test "$@" 2>/dev/null)
}
stages() { wc -l <"$tree/calls"; }

bazel_says "//tests/kernels:a_test          PASSED in 0.1s"
said=$(run_test) || fail "a suite that passes fails: $said"
[[ $said == *"6 passed, 0 failed, 1 skipped" ]] || fail "counts otherwise: $said"
[ "$(stages)" = 1 ] || fail "runs more than the suite"

bazel_says "[0 / 6] checking cached actions
[12 / 1,345] Compiling vision/a.cc; 3s linux-sandbox
//tests/kernels:a_test          PASSED in 0.1s"
said=$(cd "$tree" && PATH=$tree/tools_on_path bash ./run test 2>&1) || fail "progress is a failure: $said"
[[ $said == *"12 of 1,345 steps are done"* && $said != *"0 of 6"* ]] || fail "tells other progress: $said"

for shard in 1 2; do
  mkdir -p "$tree/bazel-testlogs/tests/kernels/b_test/shard_${shard}_of_2"
  cp "$tree/bazel-testlogs/tests/kernels/a_test/test.xml" "$tree/bazel-testlogs/tests/kernels/b_test/shard_${shard}_of_2"
done
bazel_says "//tests/kernels:b_test          PASSED in 0.1s"
said=$(run_test) || fail "a sharded suite that passes fails: $said"
[[ $said == *"12 passed, 0 failed, 2 skipped" ]] || fail "counts other shards: $said"

bazel_says "INFO: From Compiling kernels/a.cc:
kernels/a.cc:3:7: warning: unused variable 'b' [-Wunused-variable]
//tests/kernels:a_test          PASSED in 0.1s"
! said=$(run_test) || fail "a warning is no failure: $said"
[[ $said == *"warning: unused"*"6 passed, 1 failed, 1 skipped" ]] || fail "tells no warning: $said"
bazel_says "/usr/include/a.h:3:7: warning: of others
//tests/kernels:a_test          PASSED in 0.1s"
run_test >/dev/null || fail "a warning of others' headers is a failure"

bazel_says "//tests/kernels:a_test          FAILED in 0.1s"
! said=$(run_test) || fail "a failure passes: $said"
[[ $said == *"1 failed"* ]] || fail "counts no failure: $said"

bazel_says "//tests/kernels:a_test          PASSED in 0.1s"
EGOSIEVE_SANITIZE_WITHIN=600 run_test >/dev/null || fail "sanitizers that pass fail"
[ "$(grep -c -- --config=asan "$tree/calls")" = 1 ] || fail "no address sanitizer in time"
[ "$(grep -c -- --config=tsan "$tree/calls")" = 1 ] || fail "no thread sanitizer in time"
EGOSIEVE_SANITIZE_WITHIN=0 run_test >/dev/null || fail "fails without sanitizers"
[ "$(stages)" = 1 ] || fail "sanitizers beyond the time"

EGOSIEVE_TIDY_UNTIL=600 run_test >/dev/null || fail "fails without clang-tidy"
program() {
  printf '#!/bin/bash\n%s\n' "$2" >"$tree/tools_on_path/$1"
  chmod +x "$tree/tools_on_path/$1"
}
program git "echo \"\$*\" >>$tree/asked
case \$1 in diff) echo kernels/b.cc ;; ls-files) printf '%s\\n' gp/c.cc kernels/a.cc kernels/b.cc ;; esac"
program clang-tidy "echo \"\$*\" >>$tree/tidied; [[ \$* != *b.cc* ]]"
: >"$tree/tidied"
: >"$tree/asked"
! said=$(EGOSIEVE_TIDY_UNTIL=600 run_test) || fail "a finding is no failure: $said"
[[ $said == *"6 passed, 1 failed, 1 skipped" ]] || fail "counts clang-tidy otherwise: $said"
[ "$(sed 's/.* \(.*\.cc\) --.*/\1/' "$tree/tidied" | tr '\n' ' ')" = "kernels/b.cc gp/c.cc kernels/a.cc " ] ||
  fail "clang-tidy has not seen all, what is new first: $(cat "$tree/tidied")"
grep -qx -- 'ls-files gp/\*.cc kernels/\*.cc' "$tree/asked" || fail "checks other folders: $(cat "$tree/asked")"
EGOSIEVE_TIDY_UNTIL=0 run_test >/dev/null || fail "clang-tidy beyond the time"
run_test >/dev/null || fail "clang-tidy unasked"
