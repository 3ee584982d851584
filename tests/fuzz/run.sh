#!/usr/bin/env bash
# Fuzzes each reader in turn and adds the best of what it finds to the corpus:
#
#   tests/fuzz/run.sh                  an hour each
#   tests/fuzz/run.sh 600              600 seconds each
#   tests/fuzz/run.sh 600 model        600 seconds of one
#   tests/fuzz/run.sh 0                no fuzzing: only drops inputs that others make needless
#
# It needs `cargo install --locked cargo-fuzz`, and a C++ compiler. A fault ends it: the input is in
# tests/fuzz/artifacts, and `cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none TARGET FILE` runs
# it again. Fix the cause, and put the input into tests/fuzz/corpus/TARGET under a name that states
# the fault. `cargo xtask test -- fuzz_corpus` runs it from then on.
set -euo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-3600}
shift || true
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  targets=(scene_file model gltf picture preset results)
fi
# The corpus has no more files than this, all targets together.
most=300
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
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
    if [ "$seconds" -gt 0 ]; then
      FIRST_INPUTS=$(realpath "$found") fuzz run "$found" -- "${options[@]}"
    fi
    continue
  fi
  corpus="tests/fuzz/corpus/$target"
  inputs=("$corpus")
  if [ "$seconds" -gt 0 ]; then
    fuzz run "$found" "$corpus" -- "${options[@]}"
    # Small inputs are enough.
    mkdir "$scratch/$target-small"
    find "$found" -type f -size -2049c -exec cp -t "$scratch/$target-small" {} +
    inputs+=("$scratch/$target-small")
  fi

  # libFuzzer lists the edges (branches of the compiled code) that each input reaches. One thread: what threads do differs from run
  # to run. The smallest inputs come first.
  mkdir "$scratch/$target-merged"
  list="$scratch/$target-list"
  RAYON_NUM_THREADS=1 fuzz run "$scratch/$target-merged" "${inputs[@]}" -- \
    -set_cover_merge=1 -use_counters=0 -max_len=16384 -merge_control_file="$list"
  # Keeps the inputs with a name of their own (libFuzzer's names are hashes), and then one by one the input that adds most: an edge
  # that the corpus has counts ten, another one. An input that adds less than ten is not kept: most edges that are reached alone
  # are one more error of a parser that isn't ours.
  others=$(find tests/fuzz/corpus -type f -not -path "$corpus/*" | wc -l)
  awk -v corpus="$corpus/" -v room=$((most - others)) '
    function adds(i,    all, n, e, sum) {
      n = split(edges[i], all, " ")
      # The first two are the word FT and the number of the input, the last is how deep the stack was.
      for (e = 3; e < n; e++) if (!(all[e] in reached)) sum += (all[e] in old) ? 10 : 1
      return sum + 0
    }
    function keep(i,    all, n, e) {
      n = split(edges[i], all, " ")
      for (e = 3; e < n; e++) reached[all[e]]
      at_most[i] = 0
      kept++
      print path[i]
    }
    NR == 1 { count = $1 }
    NR > 2 && NR <= count + 2 { path[NR - 3] = $0 }
    $1 == "FT" && NR > count + 2 {
      edges[$2] = $0
      if (index(path[$2], corpus) == 1) for (e = 3; e < NF; e++) old[$e]
    }
    END {
      for (i = 0; i < count; i++) {
        at_most[i] = 1e9
        name = path[i]
        sub(/.*\//, "", name)
        if (index(path[i], corpus) == 1 && (length(name) != 40 || name ~ /[^0-9a-f]/)) keep(i)
      }
      while (kept < room) {
        best = -1
        most = 9
        for (i = 0; i < count; i++) {
          # What an input adds only shrinks.
          if (at_most[i] <= most) continue
          at_most[i] = adds(i)
          if (at_most[i] > most) { most = at_most[i]; best = i }
        }
        if (best < 0) break
        keep(best)
      }
    }' "$list" >"$scratch/$target-kept"
  # The folder is replaced by what is kept.
  mkdir "$scratch/$target-new"
  xargs -d '\n' -a "$scratch/$target-kept" cp -t "$scratch/$target-new"
  rm -r "$corpus"
  mv "$scratch/$target-new" "$corpus"
  echo "$corpus: $(find "$corpus" -type f | wc -l) files"
done
