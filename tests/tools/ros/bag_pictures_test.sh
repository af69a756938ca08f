#!/usr/bin/env bash
# By the interpreter that `./run bag` makes, since rosbags is no package of Debian.
set -euo pipefail

source tests/shell/skip.sh
python=${XDG_CACHE_HOME:-${HOME:-/nowhere}/.cache}/egosieve/ros/bin/python
"$python" -c "import rosbags.image" 2>/dev/null || skip bag_pictures_test "rosbags is not installed; ./run bag installs it"
"$python" tests/tools/ros/bag_pictures_test.py tools/ros/bag_pictures.py
