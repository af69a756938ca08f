#!/usr/bin/env bash
# Every header and source of C and C++ is as clang-format 14 (Debian 12's) leaves it; other versions lay out some things otherwise.
set -euo pipefail
. tests/shell/skip.sh
clang-format --version 2>/dev/null | grep -q 'version 14\.' || skip format_test "there is no clang-format 14"
cd "$(dirname "$(readlink -f run)")"
find bench gp kernels tests tools vision \( -name '*.h' -o -name '*.hpp' -o -name '*.cc' -o -name '*.c' \) -print0 | xargs -0 clang-format --dry-run -Werror
