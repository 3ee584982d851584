#!/usr/bin/env bash
# Makes the figures and pictures of docs/others.md again, into target/others, and the pictures that the page shows into docs/others.
# Bevy (examples/bevy, whose build is long) and three-d (examples/three_d) are built, too; `--without-bevy` and `--without-three-d` leave them out.
set -euo pipefail
cd "$(dirname "$0")/.."
with_bevy=yes
with_three_d=yes
for argument in "$@"; do
  case "$argument" in
    --without-bevy) with_bevy=no ;;
    --without-three-d) with_three_d=no ;;
    *)
      echo "docs/others.sh: '$argument' is no option: use --without-bevy, --without-three-d" >&2
      exit 2
      ;;
  esac
done
report=target/others
mkdir -p "$report/presets" docs/others
# Graphics drivers look for a display's socket there at each start, and complain where it isn't set.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$(mktemp -d)}"

# One setting of contact shadows: how many pixels, how thick.
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
cargo run --release --example measure_others -- compare street forest valley hovering-feet thin-plate \
  --technique contact,hard --map-sizes 1024 "${presets[@]}" --out "$report/contact"

# Cuts the place with the balconies out of a picture.
crop() {
  cargo run --quiet --release --example crop -- "$1" 60,170 "$2"
}
crop "$report/contact/street/truth.png" docs/others/contact.truth.png
for setting in 0-0.005 60-0.005 60-0.1; do
  for end in png error.png; do
    crop "$report/contact/street/contact-$setting.cpu.$end" "docs/others/contact.$setting.$end"
  done
done

cargo run --release --example panes -- docs/others

if [[ "$with_bevy" == yes ]]; then
  cargo run --release --ignore-rust-version --manifest-path examples/bevy/Cargo.toml -- street thin-plate street-soft --out "$report/bevy"
  for setting in truth Bevy-as-far-as-is-seen Bevy-as-far-as-is-seen-contact-shadows umbrage-pcf-3x3-4-cascades-of-2048 umbrage-exact; do
    crop "$report/bevy/street.$setting.png" "docs/others/bevy.$setting.png"
  done
fi

if [[ "$with_three_d" == yes ]]; then
  cargo run --release --manifest-path examples/three_d/Cargo.toml -- street thin-plate --out "$report/three_d"
  for setting in truth three-d-2048 umbrage-pcf-3x3-2048 umbrage-pcf-3x3-4-cascades-of-2048; do
    crop "$report/three_d/street.$setting.png" "docs/others/three_d.$setting.png"
  done
fi
