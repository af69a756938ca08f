#!/usr/bin/env bash
# ./run demo leaves what is not its own. The script runs in a tree of its own with a program that only leaves what the real
# one would; its folders' contents are the commands' own business.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

tree=$TEST_TMPDIR/tree
mkdir -p "$tree"/{bazel-bin/tools,tools/evaluate,tools_on_path}
cp run "$tree/run"
cat >"$tree/bazel-bin/tools/egosieve" <<'END'
#!/usr/bin/env bash
echo "$*" >>"$(dirname "$0")/calls"
case "$1" in
  synthesize) mkdir -p "${4#--out=}" ;;
  segment) mkdir -p "${3#--out=}" ;;
esac
END
printf '#!/bin/sh\necho "pooled AUC 0.9 of 80 frames"\n' >"$tree/tools/evaluate/egosieve-eval"
# Without dpkg-query and with a bazel, the script takes its packages for installed.
for name in bash dirname mkdir sed tail tee; do
  ln -s "$(command -v "$name")" "$tree/tools_on_path/$name"
done
printf '#!/bin/sh\necho "$*" >>%s/built\n' "$tree" >"$tree/tools_on_path/bazel"
chmod +x "$tree/bazel-bin/tools/egosieve" "$tree/tools/evaluate/egosieve-eval" "$tree/tools_on_path/bazel"

demo() {
  : >"$tree/bazel-bin/tools/calls"
  (cd "$tree" && PATH=$tree/tools_on_path bash ./run demo "$@" 2>&1)
}

mine=$TEST_TMPDIR/mine
mkdir "$mine"
echo "a year's work" >"$mine/thesis.tex"
! demo "$mine/thesis.tex" || fail "took a file for a folder"
! demo "$mine/a" "$mine/b" || fail "took two folders"
! demo --overwrite=yes "$mine/a" || fail "took an unknown flag"
[ "$(ls "$mine")" = thesis.tex ] || fail "wrote before it refused: $(ls "$mine")"

demo "$mine" | grep -qx "demo: pooled AUC 0.9, results in $mine" || fail "no demo: $(demo "$mine")"
grep -q ' //tools:egosieve$' "$tree/built" || fail "did not build the program"
! grep -q -- --overwrite "$tree/bazel-bin/tools/calls" || fail "replaces a demo unasked"
demo "$mine" --overwrite >/dev/null || fail "did not replace a demo"
[ "$(grep -c -- " --overwrite$" "$tree/bazel-bin/tools/calls")" = 2 ] || fail "the commands were not told"
[ "$(cat "$mine/thesis.tex")" = "a year's work" ] || fail "removed what no demo wrote"

# Where no folder is named, a former demo is in nobody's way.
demo >/dev/null || fail "no demo in out/demo"
[ "$(grep -c -- "--out=$tree/out/demo/.* --overwrite$" "$tree/bazel-bin/tools/calls")" = 2 ] || fail "out/demo is in the way"

printf '#!/bin/sh\necho "a.cc:1: error: no" >&2; exit 1\n' >"$tree/tools_on_path/bazel"
! said=$(demo) || fail "goes on without a build: $said"
[[ $said == *"a.cc:1: error: no"*"the build failed"* ]] || fail "does not say why: $said"
printf '#!/bin/sh\necho "[0 / 6] checking cached actions"; echo "[12 / 1,345] Compiling vision/a.cc; 3s linux-sandbox"\n' >"$tree/tools_on_path/bazel"
said=$(demo) || fail "no demo after a build: $said"
[[ $said == *"run: 12 of 1,345 steps are done"* ]] || fail "shows no progress: $said"
[[ $said != *"0 of 6"* ]] || fail "tells that nothing is done: $said"
