#!/usr/bin/env bash
# Fuzzes each reader in turn and adds what it finds to the corpus:
#
#   tests/fuzz/run.sh                  an hour each
#   tests/fuzz/run.sh 600              600 seconds each
#   tests/fuzz/run.sh 600 model        600 seconds of one
#
# It needs `cargo install --locked cargo-fuzz`, and a C++ compiler. A fault ends it: the input is in tests/fuzz/artifacts,
# `cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none TARGET FILE` plays it again. Mend the cause, put the input into
# tests/fuzz/corpus/TARGET under a name that tells the fault, and `cargo xtask test -- fuzz_corpus` plays it from then on.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-3600}
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  targets=(scene_file model gltf picture preset results)
fi
for target in "${targets[@]}"; do
  # The workspace forbids unsafe code, so that sanitizers of memory would only make it slower.
  fuzz() { cargo fuzz "$1" --fuzz-dir tests/fuzz --sanitizer none "$target" "${@:2}"; }
  # What is found on the way stays here: much of it tells no more than a smaller input does.
  found="${CARGO_TARGET_DIR:-target}/fuzz-found/$target"
  mkdir -p "$found"
  dictionary="tests/fuzz/dictionaries/$target.dict"
  options=(-max_total_time="$seconds" -timeout=30 -rss_limit_mb=4096 -max_len=16384 -print_final_stats=1)
  if [ -f "$dictionary" ]; then
    options+=(-dict="$dictionary")
  fi
  if [ "$target" = gltf ]; then
    # Models are made in code, and none is kept: a fault becomes a test beside the reader.
    FIRST_INPUTS=$(realpath "$found") fuzz run "$found" -- "${options[@]}"
    continue
  fi
  fuzz run "$found" "tests/fuzz/corpus/$target" -- "${options[@]}"
  # Keeps few small inputs that together reach all code that was reached, however often.
  fuzz run "tests/fuzz/corpus/$target" "$found" -- -merge=1 -use_counters=0 -max_len=2048
done
