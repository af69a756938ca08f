#!/usr/bin/env bash
# Dockerfile and egosieve.def, which no test here can build, run the same commands, of scripts that
# are there.
set -euo pipefail

fail() {
  echo "FAILED: $*" >&2
  exit 1
}

# The commands of the Dockerfile, a line each; --build-arg and the user that Docker alone needs left out.
docker_commands() {
  sed -e ':join;/\\$/{N;s/ *\\\n */ /;b join}' Dockerfile | sed -n 's/^RUN //p' |
    sed -e 's/ && useradd .*//' -e 's/ && /\n/g'
}

# Those of every %post, but for the folder that the Dockerfile names by WORKDIR.
apptainer_commands() {
  awk '/^%/ { post = ($1 == "%post"); next } /^Bootstrap:/ { post = 0 } post && NF' egosieve.def |
    sed -e 's/^ *//' -e '/^cd \/egosieve$/d'
}

[ "$(docker_commands | wc -l)" -ge 5 ] || fail "found too few commands in Dockerfile: $(docker_commands)"
diff <(docker_commands) <(apptainer_commands) || fail "Dockerfile and egosieve.def run other commands"

while read -r script; do
  [ -x "$script" ] || fail "$script, which the recipes run, is not there"
done < <(docker_commands | sed -nE 's#^(\./|tools/)([^ ]*).*#\1\2#p')

# Both begin with the same base image.
base=$(sed -nE 's/^ARG DEBIAN=(.*)/debian:\1-slim/p' Dockerfile)
[ "$(sed -n 's/^From: //p' egosieve.def | sort -u)" = "$base" ] || fail "the recipes begin with other images"
