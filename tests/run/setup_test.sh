#!/usr/bin/env bash
# ./run setup installs what is needed and stops where it cannot; what a distribution lacks of the
# optional packages stops nothing. dpkg-query, apt-get and bazel are stand-ins.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

tree=$TEST_TMPDIR/tree
mkdir -p "$tree"/{third_party,kernels,gp,vision,tools,tools_on_path}
cp run "$tree/run"
touch "$tree"/{BUILD,WORKSPACE,.bazelrc}
for name in bash basename cat chmod cp dirname env find grep mkdir mktemp mv rm sed tail tee touch; do
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
stand_in bazel "mkdir -p $tree/bazel-bin/tools; touch $tree/bazel-bin/tools/egosieve
echo '[12 / 1,345] Compiling vision/a.cc; 3s linux-sandbox' >&2"

setup() {
  rm -rf "$tree/.build"
  (cd "$tree" && PATH=$tree/tools_on_path bash ./run setup 2>&1)
}

: >"$tree/installed"
echo oclgrind >"$tree/lacking"
said=$(setup) || fail "stopped where an optional package is lacking: $said"
[[ $said == *"no oclgrind here"* ]] || fail "does not say what is lacking: $said"
grep -qx doxygen "$tree/installed" || fail "left out an optional package that there is"
[ -e "$tree/.build/egosieve" ] || fail "built nothing"
[[ $said == *"run: 12 of 1,345 steps are done"* ]] || fail "shows no progress: $said"
said=$(setup) || fail "the second call stopped: $said"
[[ $said != *installing* ]] || fail "installs again: $said"

: >"$tree/installed"
echo libpng-dev >"$tree/lacking"
! said=$(setup) || fail "goes on without a needed package: $said"
[ ! -e "$tree/.build/egosieve" ] || fail "built without a needed package"

: >"$tree/lacking"
stand_in bazel "echo 'a.cc:1: error: no' >&2; exit 1"
! said=$(setup) || fail "goes on without a build: $said"
[[ $said == *"a.cc:1: error: no"*"the build failed"* ]] || fail "does not say why: $said"
