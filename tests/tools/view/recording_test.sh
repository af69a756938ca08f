#!/usr/bin/env bash
# By the interpreter that `./run view` makes, since rerun-sdk is no package of Debian.
set -euo pipefail

source tests/shell/skip.sh
python=${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/egosieve/view/bin/python
"$python" -c "import rerun.chunk, cv2" 2>/dev/null || skip recording_test "rerun-sdk is not installed; ./run view installs it"
"$python" -B tests/tools/view/recording_test.py
