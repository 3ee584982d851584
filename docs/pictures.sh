#!/usr/bin/env bash
# Writes the images of the README and of docs, the figures of docs/failures.md, and docs/which.md. Takes about an hour.
# (`python3 examples/viewer/try.py --bless` writes docs/viewer.png.)
# It needs `pngquant` (Debian's package of that name).
set -euo pipefail
cd "$(dirname "$0")/.."
command -v pngquant >/dev/null || { echo "install pngquant first: apt-get install pngquant" >&2; exit 1; }
report=target/pictures
mkdir -p "$report"
gallery() {
  cargo run --profile measure --example gallery -- "$@"
}
cargo xtask compare teapot-lamp --map-sizes 512 --out "$report"
rows=("$report"/teapot-lamp/{hard-512-bias-none,hard-512-bias-slope-.05-.005,pcf-7x7-512-bias-adaptive}.cpu)
gallery sheet docs/teapot-lamp.png --columns 4 "$report/teapot-lamp/truth.png" "${rows[@]/%/.png}" - "${rows[@]/%/.error.png}"
printf 'technique = "pcf"\nradius = 1\n[map]\nsize = 1024\nlayout = { cascades = { count = 4 } }\n' > "$report/cascades.preset.toml"
cargo xtask compare street --color --technique none --preset "$report/cascades.preset.toml" --size 800x450 --backend cpu --out "$report/readme"
gallery sheet docs/readme.png --columns 2 "$report"/readme/street/cascades.cpu.{color,error}.png
gallery causes
gallery lists
gallery penumbrae
gallery failures
cargo xtask stability hills-yaw hills-yaw-stable --technique hard --backend cpu --out "$report/shimmer"
gallery sheet docs/failures/shimmer.png --columns 1 \
  "$report"/shimmer/pictures/{hills-yaw,hills-yaw-stable}.hard-512-4-cascades-log-from-4-m-bias-adaptive.png
mkdir -p docs/moments
cargo xtask stability two-plates --technique vsm --backend cpu --out "$report/moments"
cp "$report/moments/pictures/two-plates.vsm-blur-7x7-bleeding-0-1024-bias-adaptive.png" docs/moments/two-plates.vsm.png
gallery textbook "$report/textbook"
gallery sheet docs/textbook.png "$report"/textbook/{acne,soft,point-light,contact}.{fault,cure}.png
cargo xtask compare --out "$report/suite"
for light in hard soft; do
  cp "$report/suite/chart-time-$light-cpu.png" "docs/chart-$light.png"
done
cargo xtask stability --out "$report/stability"
cp "$report/stability/matrix.svg" docs/matrix.svg
# Times of the card, errors of the CPU.
scenes=(nave nave-soft street street-soft forest forest-soft valley valley-soft dancer dancer-soft leaf-cards leaf-cards-soft
  night-room night-room-soft hall hall-soft statue town town-soft)
cargo xtask compare "${scenes[@]}" --backend cpu --out "$report/which"
cargo xtask which "$report/which" "$report/stability" --card docs/cards/nvidia-h100.json --out docs
# A palette halves a picture and changes no pixel visibly. Pictures that a palette would enlarge stay.
for picture in docs/*.png docs/*/*.png; do
  pngquant --quality=0-90 --speed 1 --strip --ext .png --force --skip-if-larger "$picture" || [ $? = 98 ]
done
