#!/usr/bin/env bash
# ./run setup installs what is needed and stops where it cannot; what a distribution lacks of the
# optional packages stops nothing. dpkg-query, apt-get and bazel are stand-ins.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

tree=$TEST_TMPDIR/tree
mkdir -p "$tree/tools_on_path"
cp run "$tree/run"
for name in bash dirname env grep mktemp rm sed tail; do
  ln -s "$(command -v "$name")" "$tree/tools_on_path/$name"
done
stand_in() {
  printf '#!/bin/bash\n%s\n' "$2" >"$tree/tools_on_path/$1"
  chmod +x "$tree/tools_on_path/$1"
}
stand_in id 'echo 0'
stand_in dpkg-query 'for name in "$@"; do grep -qx -- "$name" '"$tree"'/installed && echo "ii $name"; done; true'
stand_in apt-get '
[ "$1" = install ] || exit 0
for name in "$@"; do case $name in -* | install) ;; *)
  grep -qx -- "$name" '"$tree"'/lacking && exit 100
  echo "$name" >>'"$tree"'/installed ;;
esac; done'
setup() {
  (cd "$tree" && PATH=$tree/tools_on_path bash ./run setup 2>&1)
}

: >"$tree/installed"
echo oclgrind >"$tree/lacking"
said=$(setup) || fail "stopped where an optional package is lacking: $said"
[[ $said == *"no oclgrind here"* ]] || fail "does not say what is lacking: $said"
grep -qx doxygen "$tree/installed" || fail "left out an optional package that there is"
grep -qx g++ "$tree/installed" || fail "left out a needed package"
said=$(setup) || fail "the second call stopped: $said"
[[ $said != *installing* ]] || fail "installs again: $said"

: >"$tree/installed"
echo libpng-dev >"$tree/lacking"
! said=$(setup) || fail "goes on without a needed package: $said"

# demo and test need what is needed, and ask for nothing else; others install nothing.
(cd "$tree" && ! PATH=$tree/tools_on_path bash ./run demo >/dev/null 2>&1) || fail "a demo without a needed package"
: >"$tree/installed"
: >"$tree/lacking"
! said=$(cd "$tree" && PATH=$tree/tools_on_path bash ./run segment a.mp4 2>&1) || fail "segments without Bazel"
[[ $said == *"./run setup"* ]] || fail "does not tell the remedy: $said"
[ ! -s "$tree/installed" ] || fail "installs unasked"
(cd "$tree" && PATH=$tree/tools_on_path bash ./run test >/dev/null 2>&1) || true
grep -qx bazel-bootstrap "$tree/installed" || fail "test installs nothing"
