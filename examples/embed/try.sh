#!/usr/bin/env bash
# Tries the window as a user would, without a screen: Xvfb shows it, xdotool moves the mouse and presses keys, and pictures of the window must
# change where they should and nowhere else.
#
# Needs Xvfb, xdotool, ImageMagick and a Vulkan driver. On Debian, as root:
#   apt-get install xvfb xdotool imagemagick libxkbcommon-x11-0 libxcursor1 libxi6 mesa-vulkan-drivers
# Then: examples/embed/try.sh [FOLDER]   (pictures of every step go to FOLDER, by default a new one)
set -euo pipefail
cd "$(dirname "$0")"

out=${1:-$(mktemp -d)}
mkdir -p "$out"
out=$(cd "$out" && pwd)
for tool in Xvfb xdotool import compare; do
    command -v "$tool" >/dev/null || { echo "needs $tool: see the head of this file" >&2; exit 1; }
done
cargo build --release
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
embed=$target/release/embed

width=640
height=480
started=()
finish() {
    for pid in "${started[@]}"; do kill "$pid" 2>/dev/null || true; done
}
trap finish EXIT

failed=0
fail() { echo "FAILED: $1"; failed=1; }
ok() { echo "ok: $1"; }

# Succeeds if a command exits with a code and its messages have a word.
expect_exit() {
    local what=$1 code=$2 word=$3
    shift 3
    local found=0 said
    said=$(timeout 60 "$@" 2>&1) || found=$?
    if [ "$found" = "$code" ] && grep -q -- "$word" <<<"$said" && ! grep -q panicked <<<"$said"; then
        ok "$what"
    else
        fail "$what: exit code $found, not $code, or no word of \`$word\` in: $said"
    fi
}

# ---- What goes wrong is told in plain words.
expect_exit "broken size" 2 "write it as 1280x720" "$embed" --size 12
expect_exit "size of zero" 2 "no pixels" "$embed" --size 0x5
expect_exit "unknown technique" 2 "possible values" "$embed" --technique nothing
expect_exit "broken time" 2 "seconds" "$embed" --time soon
expect_exit "help has examples" 0 "Examples:" "$embed" --help
expect_exit "no display" 1 "without a display" env -u DISPLAY -u WAYLAND_DISPLAY "$embed"
expect_exit "a display that isn't there" 1 "without a display" env -u WAYLAND_DISPLAY DISPLAY=:987 "$embed"
expect_exit "no adapter" 1 "no graphics adapter" env VK_DRIVER_FILES=/none VK_ICD_FILENAMES=/none "$embed" --png "$out/none.png"
expect_exit "a picture too large" 1 "at most" "$embed" --png "$out/none.png" --size 100000x100
echo "technique = 'magic'" >"$out/broken.preset.toml"
expect_exit "a preset that isn't there" 1 "can't be read" "$embed" --preset "$out/none.toml" --png "$out/none.png"
expect_exit "a broken preset" 1 "can't be used" "$embed" --preset "$out/broken.preset.toml" --png "$out/none.png"
expect_exit "a folder that isn't there" 1 "can't write" "$embed" --png "$out/none/none.png" --size 64x64

# ---- Pictures: forward and deferred show the same, another technique does not.
picture() { "$embed" --png "$out/$1.png" --size ${width}x$height --time 2 "${@:2}" >/dev/null; }
# Prints how many of a hundred thousand pixels of two pictures differ by more than 3 % of white, in a part (WxH+X+Y).
differing() {
    local part=$3 count size
    count=$(compare -metric AE -fuzz 3% "$out/$1.png[$part]" "$out/$2.png[$part]" null: 2>&1 || true)
    size=${part%%+*}
    awk -v count="$count" -v w="${size%x*}" -v h="${size#*x}" 'BEGIN { printf "%d", 100000 * count / (w * h) }'
}
# Succeeds if at most so many pixels differ.
same() {
    local what=$1 found
    found=$(differing "$2" "$3" "$4")
    if [ "$found" -le "${5:-0}" ]; then ok "$what"; else fail "$what: $found of 100000 pixels differ"; fi
}
# Succeeds if at least so many do.
differs() {
    local what=$1 found
    found=$(differing "$2" "$3" "$4")
    if [ "$found" -ge "$5" ]; then ok "$what ($found of 100000 pixels)"; else fail "$what: only $found of 100000 pixels differ"; fi
}
whole=${width}x${height}+0+0
picture forward
picture deferred --deferred
picture forward-hard --technique hard
picture forward-none --technique none
echo "technique = 'hard'" >"$out/hard.preset.toml"
picture preset --preset "$out/hard.preset.toml"
differs "a preset's settings are taken" forward preset "$whole" 100
same "forward and deferred show the same" forward deferred "$whole" 100
differs "another technique differs" forward forward-hard "$whole" 100
differs "shadows are there" forward forward-none "$whole" 5000

# ---- A window.
display=:$((90 + RANDOM % 900))
Xvfb "$display" -screen 0 1000x800x24 >/dev/null 2>&1 &
started+=($!)
export DISPLAY=$display WINIT_X11_SCALE_FACTOR=1
unset WAYLAND_DISPLAY
for _ in $(seq 50); do xdotool getmouselocation >/dev/null 2>&1 && break; sleep 0.1; done
"$embed" --size ${width}x$height --time 2 >"$out/embed.log" 2>&1 &
program=$!
started+=("$program")
window=$(timeout 60 xdotool search --sync --onlyvisible --name '^embed: pcf, forward$' | head -1)
[ -n "$window" ] || { echo "no window: $(cat "$out/embed.log")" >&2; exit 1; }
xdotool windowmove "$window" 0 0 windowfocus "$window"

# The part of the window beside the panel, and that of the panel.
scene=360x${height}+280+0
panel=260x300+10+60
shot() { import -window "$window" "$out/$1.png"; }
title() { xdotool getwindowname "$window"; }
# Frames take as long as they take: waits until the scene looks otherwise than in a picture.
await_change() {
    for _ in $(seq 60); do
        shot now
        [ "$(differing "$1" now "${2:-$scene}")" -ge 100 ] && return
        sleep 1
    done
}
# Takes a picture again and again until at least so many pixels differ from another one in a part.
shot_once_changed() {
    for _ in $(seq 60); do
        shot "$1"
        [ "$(differing "$2" "$1" "$3")" -ge "$4" ] && return
        sleep 1
    done
}
# Takes a picture once the scene has come to rest.
settle() {
    shot "$1"
    for _ in $(seq 60); do
        sleep "$patience"
        mv "$out/$1.png" "$out/before.png"
        shot "$1"
        [ "$(differing before "$1" "$scene")" = 0 ] && return
    done
}
# Holds a key for a short while: a step of some metres.
press() { xdotool keydown "$1" sleep 0.3 keyup "$1"; }
# Clicks at a place of the panel. The panel takes a click where it saw the mouse in the frame before.
click() {
    xdotool mousemove --window "$window" "$1" "$2"
    sleep "$patience"
    xdotool click 1
    sleep "$patience"
}
aside() { xdotool mousemove --window "$window" 500 300; }
expect_title() {
    for _ in $(seq 60); do
        [ "$(title)" = "$2" ] && break
        sleep 1
    done
    if [ "$(title)" = "$2" ]; then ok "$1"; else fail "$1: the title is $(title)"; fi
}

# Seconds that a few frames take, from how soon the window answers.
patience=1
aside
shot start
begin=$(date +%s)
press e
await_change start
patience=$((1 + $(date +%s) - begin))
begin=$(date +%s)
settle risen
press q
await_change risen
settle start
echo "the window answers within $patience s"

# ---- The right mouse button looks around. Without it the mouse does nothing.
settle still
same "nothing changes by itself" start still "$scene"
xdotool mousemove_relative -- 60 20
sleep "$patience"
settle moved
same "the mouse alone turns nothing" start moved "$scene"
xdotool mousedown 3
sleep "$patience"
for _ in 1 2 3 4 5; do xdotool mousemove_relative -- 20 4; done
await_change start
settle turned
xdotool mouseup 3
differs "the right button looks around" start turned "$scene" 10000
sleep "$patience"
settle released
same "the view stays as the button is released" turned released "$scene"
xdotool mousemove_relative -- -80 -30
sleep "$patience"
settle moved
same "the mouse turns nothing any more" released moved "$scene"
# Back to where things move.
aside
xdotool mousedown 3
sleep "$patience"
for _ in 1 2 3 4 5; do xdotool mousemove_relative -- -20 -4; done
await_change moved
settle back
xdotool mouseup 3
sleep "$patience"
settle back
differs "and back" moved back "$scene" 10000

# ---- Keys fly. Back and forth, so that there is something to see.
last=back
for key in w s a d e q space Shift_L; do
    press "$key"
    await_change "$last"
    settle "key-$key"
    differs "$key flies" "$last" "key-$key" "$scene" 1000
    last=key-$key
done
sleep "$patience"
settle keys
same "no key flies on" "$last" keys "$scene"

# ---- The wheel changes the speed, which the panel tells.
xdotool click 4 click 4
sleep "$patience"
settle wheel
differs "the wheel changes the speed" keys wheel "200x18+16+309" 500
same "and moves nothing" keys wheel "$scene"

# ---- The panel, from its lower end up: what is lower moves as techniques have more or less numbers.
click 24 295
expect_title "a click on \`deferred\` shades deferred" "embed: pcf, deferred"
aside
settle deferred
same "deferred shows the same" wheel deferred "$scene" 100
click 24 295
expect_title "another click shades forward" "embed: pcf, forward"
click 125 272
aside
await_change wheel
settle perspective
differs "the sun's projection becomes perspective" wheel perspective "$scene" 1000
click 24 272
aside
await_change perspective
settle orthographic
same "and orthographic again" wheel orthographic "$scene"

click 101 295
aside
await_change orthographic
shot moving
differs "things move" orthographic moving "$scene" 100
click 101 295
aside
settle rest

# The list of techniques: items are 23 pixels apart.
click 65 62
shot_once_changed list rest "$panel" 5000
differs "the list of techniques opens" rest list "$panel" 5000
# `planar`, which the set refuses.
xdotool mousemove --window "$window" 50 318
shot_once_changed refused list "360x200+130+280" 2000
differs "the reason of a technique that can't be chosen is shown" list refused "360x200+130+280" 2000
xdotool click 1
sleep "$patience"
expect_title "a greyed technique can't be chosen" "embed: pcf, forward"
# `hard`. The list has closed.
click 65 62
click 45 111
expect_title "a click takes another technique" "embed: hard, forward"
aside
await_change rest
settle hard
differs "the picture shows the other technique" rest hard "$scene" 100
[ "$(grep -c . "$out/embed.log")" = 0 ] || fail "the program says: $(cat "$out/embed.log")"

# All other techniques that can be chosen, one after the other.
last=$(title)
for y in 88 134 157 180 203 226 249 272 295; do
    click 65 62
    click 45 "$y"
    aside
    settle "technique-$y"
    if [ "$(title)" != "$last" ]; then ok "and $(title)"; else fail "a click at $y takes no other technique than $last"; fi
    last=$(title)
done

# ---- Windows get smaller and larger.
before=$(title)
for size in "200 150" "1 1" "3 400" "${width} ${height}"; do
    # shellcheck disable=SC2086
    xdotool windowsize --sync "$window" $size
    sleep "$patience"
done
aside
settle resized
# The panel keeps the smaller size that it had, so what is compared begins farther to the right.
same "the window shows the same after it was small" "technique-295" resized "340x${height}+300+0"
[ "$(title)" = "$before" ] || fail "the title changed to $(title)"

if kill -0 "$program" && [ ! -s "$out/embed.log" ]; then
    ok "the program ran without a word"
else
    fail "the program ended, or said: $(cat "$out/embed.log")"
fi

echo "pictures of all steps are in $out"
if [ $failed != 0 ]; then echo "some steps failed"; fi
exit $failed
