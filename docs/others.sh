#!/usr/bin/env bash
# Writes the figures of docs/others.md to target/others, and the images of the page to docs/others.
# Also builds Bevy (a long build) and three-d; `--without-bevy` and `--without-three-d` omit them.
set -euo pipefail
cd "$(dirname "$0")/.."
with_bevy=yes
with_three_d=yes
for argument in "$@"; do
  case "$argument" in
    --without-bevy) with_bevy=no ;;
    --without-three-d) with_three_d=no ;;
    *)
      echo "docs/others.sh: unknown option '$argument': use --without-bevy, --without-three-d" >&2
      exit 2
      ;;
  esac
done
report=target/others
mkdir -p "$report/presets"
# Graphics drivers look for a display's socket there at each start, and print a warning if it isn't set.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"

# Writes a preset of contact shadows: number of pixels, thickness.
contact() {
  printf 'technique = "contact"\nradius = 1\npixels = %s\nthickness = %s\n\n[map]\nsize = 1024\nlayout = { cascades = { count = 4 } }\n' \
    "$1" "$2" > "$report/presets/contact-$1-$2.preset.toml"
}
contact 0 0.005
contact 60 0.002
contact 60 0.005
contact 60 0.02
contact 60 0.1
contact 240 0.005
presets=()
for file in "$report"/presets/*.preset.toml; do
  presets+=(--preset "$file")
done
cargo run --release --example measure -- compare street forest valley hovering-feet thin-plate \
  --technique contact,hard --map-sizes 1024 "${presets[@]}" --out "$report/contact"

# Writes the part of several images with the balconies to one file. Arguments: its name, images a row, the images.
balconies() {
  cargo run --quiet --release --example gallery -- sheet "docs/others/$1.png" --columns "$2" --crop 60,170 "${@:3}"
}
street=$report/contact/street
balconies contact 4 "$street/truth.png" "$street"/contact-{0-0.005,60-0.005,60-0.1}.cpu.png \
  - "$street"/contact-{0-0.005,60-0.005,60-0.1}.cpu.error.png

cargo run --release --example panes -- docs/others

engines=(cargo run --release --manifest-path examples/rivals/engines/Cargo.toml)
if [[ "$with_bevy" == yes ]]; then
  "${engines[@]}" --ignore-rust-version --features bevy --bin rival_bevy -- street thin-plate street-soft --out "$report/bevy"
  balconies bevy 3 "$report"/bevy/street.{truth,Bevy-as-far-as-is-seen,Bevy-as-far-as-is-seen-contact-shadows}.png \
    "$report"/bevy/street.{umbrage-pcf-3x3-4-cascades-of-2048,umbrage-exact}.png
fi

if [[ "$with_three_d" == yes ]]; then
  "${engines[@]}" --features three_d --bin rival_three_d -- street thin-plate --out "$report/three_d"
  balconies three_d 2 "$report"/three_d/street.{truth,three-d-2048,umbrage-pcf-3x3-2048,umbrage-pcf-3x3-4-cascades-of-2048}.png
fi
