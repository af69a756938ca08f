#!/usr/bin/env bash
# The documents become a site without a warning, and a broken link would be one.
set -euo pipefail
. tests/shell/skip.sh
command -v mkdocs >/dev/null || skip site_test "there is no mkdocs"
cd "$(dirname "$(readlink -f run)")"
docs/build_site "$TEST_TMPDIR/site"
[ -s "$TEST_TMPDIR/site/index.html" ] && [ -s "$TEST_TMPDIR/site/docs/concepts.html" ]

copy=$TEST_TMPDIR/copy
mkdir "$copy"
cp -r --parents ./*.md docs bench/results tools/embed tools/examples tools/schema "$copy"
echo '[nowhere](nowhere.md)' >>"$copy/docs/concepts.md"
cd "$copy"
if docs/build_site "$TEST_TMPDIR/broken" 2>"$TEST_TMPDIR/errors"; then
  echo "FAILED: a broken link passed"
  exit 1
fi
grep -q 'nowhere\.md' "$TEST_TMPDIR/errors" || { echo "FAILED: the broken link is not named"; cat "$TEST_TMPDIR/errors"; exit 1; }
