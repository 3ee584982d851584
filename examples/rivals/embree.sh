#!/usr/bin/env bash
# Times lookups of `exact` in turn with rays of Embree 4, on all cores: prints the table that docs/measured.md shows.
#
#   examples/rivals/embree.sh [SCENE]...
#
# Without a name: all speed and content scenes, some minutes. Needs Python with pip, a C compiler, x86-64 Linux and, once, the network:
# Embree's library comes out of a package of PyPI, into target/embree, and becomes no dependency of anything here.
set -euo pipefail
cd "$(dirname "$0")/../.."
version=4.4.0.post1
folder=$PWD/target/embree
if [ ! -d "$folder/package" ]; then
  mkdir -p "$folder"
  python3 -m pip download --no-deps --only-binary :all: --dest "$folder/wheel" "embreex==$version"
  python3 -m zipfile -e "$folder"/wheel/embreex-*.whl "$folder/package"
fi
library=$(echo "$folder"/package/embreex.libs/libembree4*)
${CC:-cc} -O2 -pthread -o "$folder/embree" examples/rivals/embree.c -ldl
cargo run --release --example embree -- "$folder/embree" "$library" "$folder/scene" "$@"
