#!/usr/bin/env bash
# Makes the README's pictures again. The picture of the report needs Chromium.
set -euo pipefail
cd "$(dirname "$0")/.."
report=target/pictures
cargo xtask compare teapot-lamp --map-sizes 512 --out "$report"
mkdir -p docs/compare/teapot-lamp
cp "$report"/teapot-lamp/truth.png docs/compare/teapot-lamp/
for row in hard-512-bias-none hard-512-bias-slope-.05-.005 pcf-7x7-512-bias-polygon-offset-7-4; do
  cp "$report/teapot-lamp/$row.cpu.png" "$report/teapot-lamp/$row.cpu.error.png" docs/compare/teapot-lamp/
done
cargo run --release --example causes -- docs/causes
cargo run --release --example textbook -- "$report/textbook"
mkdir -p docs/textbook
for name in acne soft point-light contact; do
  cp "$report/textbook/$name.fault.png" "$report/textbook/$name.cure.png" docs/textbook/
done
chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --hide-scrollbars \
  --window-size=1200,1650 --virtual-time-budget=8000 --user-data-dir="$(mktemp -d)" \
  --screenshot="$PWD/docs/report.png" "file://$PWD/$report/index.html"
