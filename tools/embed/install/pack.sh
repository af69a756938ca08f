#!/usr/bin/env bash
# Lays the installed tree out and packs it: pack.sh OUT.tar FILE... Where a file goes follows from its name.
# Equal files give equal archives.
set -euo pipefail

out=$PWD/$1
shift
tree=$(mktemp -d)
trap 'rm -rf "$tree"' EXIT
for file in "$@"; do
  case $file in
    */debian_python/name) python=$tree/lib/$(<"$file")/site-packages/egosieve ;;
  esac
done
mkdir -p "$tree"/{bin,include/egosieve,lib/{cmake/egosieve,pkgconfig},share/{bash-completion/completions,doc/egosieve,egosieve/{examples,schema},man/man1}} "$python"

templates=()
version= abi= gp_libs= vision_libs=
for file in "$@"; do
  name=${file##*/}
  case $file in
    */tools/embed/include/egosieve/types.h | tools/embed/include/egosieve/types.h)
      abi=$(sed -n 's/^#define EGOSIEVE_ABI_VERSION //p' "$file") ;;&
    *tools/cli/version.h) version=$(sed -n 's/.*kVersion\[\] = "\(.*\)";/\1/p' "$file") ;;
    *tools/embed/include/egosieve/*) cp "$file" "$tree/include/egosieve/" ;;
    *tools/examples/*)
      folder=$tree/share/egosieve/examples/$(dirname "${file#*tools/examples/}")
      mkdir -p "$folder" && cp "$file" "$folder/" ;;
    *tools/embed/python/*) cp "$file" "$python/" ;;
    *.schema.json) cp "$file" "$tree/share/egosieve/schema/" ;;
    */egosieve.1) cp "$file" "$tree/share/man/man1/" ;;
    */egosieve.bash) cp "$file" "$tree/share/bash-completion/completions/egosieve" ;;
    *.md) cp "$file" "$tree/share/doc/egosieve/" ;;
    *tools/evaluate/*) mkdir -p "$tree/lib/egosieve/evaluate" && cp "$file" "$tree/lib/egosieve/evaluate/" ;;
    *tools/view/*) mkdir -p "$tree/lib/egosieve/view" && cp "$file" "$tree/lib/egosieve/view/" ;;
    */libegosieve*.so.* | */libegosieve*.a) cp "$file" "$tree/lib/" ;;
    */debian_python/name) ;;
    */egosieve.libs) gp_libs=$(<"$file") ;;
    */egosieve_vision.libs) vision_libs=$(<"$file") ;;
    *.in) templates+=("$file") ;;
    *tools/egosieve) cp "$file" "$tree/bin/" ;;
    *) echo "pack.sh: no place for $file" >&2; exit 1 ;;
  esac
done
for library in "$tree"/lib/*.so."$abi"; do
  ln -s "${library##*/}" "${library%."$abi"}"
done
for template in "${templates[@]}"; do
  name=$(basename "$template" .in)
  folder=$tree/lib/cmake/egosieve
  [ "${name##*.}" = pc ] && folder=$tree/lib/pkgconfig
  sed -e "s|@VERSION@|$version|; s|@ABI@|$abi|; s|@GP_LIBS@|${gp_libs% }|; s|@VISION_LIBS@|${vision_libs% }|" \
    "$template" >"$folder/$name"
done
find "$tree" -type d -exec chmod 755 {} +
find "$tree" -type f -exec chmod 644 {} +
find "$tree/bin" -type f -exec chmod 755 {} +
for program in "$tree"/lib/egosieve/*/egosieve-*; do
  [ -e "$program" ] || continue
  chmod 755 "$program"
  ln -s "..${program#"$tree"}" "$tree/bin/${program##*/}"
done
chmod 755 "$tree"/lib/*.so.*
tar --create --file="$out" --directory="$tree" --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner .
