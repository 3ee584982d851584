#!/usr/bin/env bash
# Makes the pictures of the README and of the pages in docs, the figures of docs/failures.md, and docs/which.md again: some half an hour.
# (docs/embed.png is `examples/embed -- --png`, docs/viewer.png is made by examples/viewer/try.py.)
set -euo pipefail
cd "$(dirname "$0")/.."
report=target/pictures
cargo xtask compare teapot-lamp --map-sizes 512 --out "$report"
mkdir -p docs/compare/teapot-lamp
cp "$report"/teapot-lamp/truth.png docs/compare/teapot-lamp/
for row in hard-512-bias-none hard-512-bias-slope-.05-.005 pcf-7x7-512-bias-adaptive; do
  cp "$report/teapot-lamp/$row.cpu.png" "$report/teapot-lamp/$row.cpu.error.png" docs/compare/teapot-lamp/
done
cargo run --profile measure --example causes -- docs/causes
cargo run --profile measure --example lists -- docs/exact
cargo run --profile measure --example penumbrae -- docs/soft
cargo run --profile measure --example failures
cargo xtask stability hills-yaw hills-yaw-stable --technique hard --backend cpu --out "$report/shimmer"
for half in fault:hills-yaw.hard-512 cure:hills-yaw-stable.hard-512; do
  cp "$report/shimmer/pictures/${half#*:}-4-cascades-log-from-4-m-bias-adaptive.png" "docs/failures/shimmer.${half%%:*}.png"
done
mkdir -p docs/moments
cargo xtask stability two-plates --technique vsm --backend cpu --out "$report/moments"
cp "$report/moments/pictures/two-plates.vsm-blur-7x7-bleeding-0-1024-bias-adaptive.png" docs/moments/two-plates.vsm.png
cargo run --profile measure --example textbook -- "$report/textbook"
mkdir -p docs/textbook
for name in acne soft point-light contact; do
  cp "$report/textbook/$name.fault.png" "$report/textbook/$name.cure.png" docs/textbook/
done
cargo xtask compare --out "$report/suite"
for light in hard soft; do
  cp "$report/suite/chart-time-$light-cpu.png" "docs/chart-$light.png"
done
cargo xtask stability --out "$report/stability"
cp "$report/stability/matrix.svg" docs/matrix.svg
cargo xtask which "$report/suite" "$report/stability" --out docs
