#!/usr/bin/env bash
# ./run demo removes nothing that no demo wrote. The script runs in a tree of its own with a program
# that only leaves what the real one would; its folders' contents are the commands' own business.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

tree=$TEST_TMPDIR/tree
mkdir -p "$tree"/{.build,third_party,kernels,gp,vision,tools,tools_on_path}
cp run "$tree/run"
touch "$tree"/{BUILD,WORKSPACE,.bazelrc}
cat >"$tree/.build/egosieve" <<'END'
#!/usr/bin/env bash
echo "$*" >>"$(dirname "$0")/calls"
case "$1" in
  synthesize) mkdir -p "${4#--out=}" ;;
  segment) mkdir -p "${3#--out=}" ;;
esac
END
mkdir "$tree/tools/evaluate"
printf '#!/bin/sh\necho "pooled AUC 0.9 of 80 frames"\n' >"$tree/tools/evaluate/egosieve-eval"
chmod +x "$tree/.build/egosieve" "$tree/tools/evaluate/egosieve-eval"
touch -d "+1 hour" "$tree/.build/egosieve"
# Without dpkg-query and with a bazel, the script takes its packages for installed.
for name in bash basename cat chmod cp dirname find grep mkdir mktemp mv rm sed tail tee touch; do
  ln -s "$(command -v "$name")" "$tree/tools_on_path/$name"
done
printf '#!/bin/sh\nexit 1\n' >"$tree/tools_on_path/bazel"
chmod +x "$tree/tools_on_path/bazel"

demo() {
  : >"$tree/.build/calls"
  (cd "$tree" && PATH=$tree/tools_on_path /usr/bin/env bash ./run demo "$@" 2>&1)
}

mine=$TEST_TMPDIR/mine
mkdir "$mine"
echo "a year's work" >"$mine/thesis.tex"
for flag in "" --overwrite; do
  ! demo "$mine" $flag || fail "took somebody's folder"
  [ "$(ls "$mine")" = thesis.tex ] || fail "changed somebody's folder: $(ls "$mine")"
  [ ! -s "$tree/.build/calls" ] || fail "did something before it refused"
done
ln -s "$mine" "$TEST_TMPDIR/link"
! demo "$TEST_TMPDIR/link" --overwrite || fail "followed a link"
! demo "$mine/thesis.tex" || fail "took a file for a folder"
! demo "$mine/a" "$mine/b" || fail "took two folders"
! demo --overwrite=yes "$mine/a" || fail "took an unknown flag"

out=$TEST_TMPDIR/out
demo "$out" | grep -qx "demo: pooled AUC 0.9, results in $out" || fail "no demo: $(demo "$out")"
echo kept >"$out/drive/kept"
! demo "$out" || fail "replaced a demo unasked"
demo "$out" --overwrite >/dev/null || fail "did not replace a demo"
[ -f "$out/drive/kept" ] || fail "removed what the commands see to"
[ "$(grep -c -- "--overwrite" "$tree/.build/calls")" = 2 ] || fail "the commands were not told"

# Where no folder is named, a former demo is in nobody's way.
demo >/dev/null || fail "no demo in out/demo"
demo >/dev/null || fail "no second demo in out/demo"
echo "a year's work" >"$tree/out/demo/thesis.tex"
! demo || fail "took out/demo with somebody's file"
