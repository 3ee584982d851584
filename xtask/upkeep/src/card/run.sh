#!/usr/bin/env bash
# Measures the graphics card of this machine with the programs in this folder: bash run.sh [PART ...]
#
# Parts: adapter agreement times light-set prices nets lists soft stability bevy. All of them take
# about ten minutes on 16 cores. Each has a time limit, and its results stay in the folder `results`
# (or $OUT) even if a later part fails. $WGPU_ADAPTER_NAME selects one of several adapters.
set -u
exec 2>&1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
out=${OUT:-$here/results}
bin=$(mktemp -d)
trap 'rm -rf "$bin"' EXIT
mkdir -p "$out"
tar -xJf "$here/bin.tar.xz" -C "$bin"
if [ -z "${XDG_RUNTIME_DIR:-}" ]; then export XDG_RUNTIME_DIR=$bin; fi

# Use the packed Vulkan loader if the machine has none, only for these programs.
if [ -d "$here/loader" ] && ! ldconfig -p | grep -q 'libvulkan\.so\.1'; then
  for package in "$here"/loader/*.deb; do dpkg -x "$package" "$bin/loader"; done
  export LD_LIBRARY_PATH=$bin/loader/usr/lib/$(uname -m)-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
fi
# Containers have NVIDIA's manifest where no loader looks.
manifest=/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json
if [ -f "$manifest" ]; then export VK_DRIVER_FILES=$manifest WGPU_BACKEND=vulkan; fi

failed=
start=$SECONDS
# limit SECONDS LOG COMMAND ...
limit() {
  local seconds=$1 log=$out/$2.log
  shift 2
  timeout "$seconds" "$@" >"$log" 2>&1
  local code=$?
  echo "exit code $code" >>"$log"
  grep -E '^test .*FAILED|^test result|decided pixels|FAULT|^error|: [0-9.]+ x$|^card:|exit code' "$log" | cut -c1-200 | tail -40
  if [ $code != 0 ]; then failed="$failed $part"; fi
}
# The file is empty if the folder was packed outside a repository.
commit=$(cat "$here/commit")
card() { limit "$1" "card-$2" "$bin/xtask-measure" card --parts "$2" --out "$out/card.json" ${commit:+--commit "$commit"}; }

cd "$out" || exit 1
# Keep figures of another commit in another file.
if [ -n "$commit" ] && [ -f card.json ] && ! grep -qF "\"commit\": \"$commit\"" card.json; then
  mv --backup=numbered card.json card-before.json
fi
for part in ${*:-adapter agreement times light-set prices nets lists soft stability bevy}; do
  echo "== $((SECONDS - start)) s: $part"
  case $part in
    adapter) card 60 adapter ;;
    agreement) card 120 agreement ;;
    times) card 150 times ;;
    light-set) card 60 light-set ;;
    prices) card 90 prices ;;
    nets)
      limit 250 nets "$bin/nets" agreement:: rasterisers:: light_set:: lists:: cascades:: exact:: soft:: cut_outs:: every_driver::
      # Tests of a second driver run on an adapter by name: the card's.
      [ -f card.json ] || card 60 adapter
      WGPU_ADAPTER_NAME=${WGPU_ADAPTER_NAME:-$(sed -n 's/.*"adapter": "\(.*\)",/\1/p' card.json | head -1)} \
        limit 200 second_driver "$bin/second_driver" on_the_second_driver
      ;;
    lists) limit 240 lists "$bin/xtask-measure" bench --lists --runs 3 ;;
    soft) limit 90 soft "$bin/xtask-measure" bench --soft --runs 1 ;;
    stability) limit 150 stability "$bin/xtask-measure" stability --backend wgpu --out "$out/stability" ;;
    bevy)
      if [ -x "$bin/rival_bevy" ]; then limit 120 bevy "$bin/rival_bevy" street street-soft --frames 15 --out "$out/bevy"; else echo "not packed"; fi
      ;;
    *) echo "error: there is no part $part; the parts are listed at the head of run.sh"; exit 2 ;;
  esac
done
echo "== $((SECONDS - start)) s: results in $out"
if [ -n "$failed" ]; then echo "failed:$failed"; exit 1; fi
