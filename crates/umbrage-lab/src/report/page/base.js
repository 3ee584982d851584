"use strict";
const dark = matchMedia("(prefers-color-scheme: dark)");
// A smaller RMSE is invisible: it is a fortieth of a step of an 8-bit image.
const EXACT = 1e-4;

const number = (v, digits) => (v === 0 ? "0" : Math.abs(v) < 10 ** -digits ? v.toExponential(1) : v.toFixed(digits));
const percent = (v) => `${number(v, 2)} %`;
const bytes = (v) => (v >= 1e6 ? `${(v / 1e6).toFixed(1)} MB` : `${(v / 1e3).toFixed(0)} kB`);
// Times have about three significant digits.
const short = (v) => (v === null ? "–" : v >= 100 ? v.toFixed(0) : v >= 10 ? v.toFixed(1) : v >= 0.1 ? v.toFixed(2) : number(v, 3));
const ms = (v) => (v === null ? "–" : `${short(v)} ms`);
const rmseWords = (v) => (v === null ? "–" : v < EXACT ? "exact" : number(v, 4));
const named = (row) => (row.settings ? `${row.technique}, ${row.settings}` : row.technique);
const firstSettings = (settings) => settings.split(", ").slice(0, 2).join(", ");
const button = (attributes, ...children) => el("button", { type: "button", ...attributes }, ...children);
// Clock that the page shows: measured time, or counted cost, the only one if nothing was timed.
let clock = data.clock;
const frameOf = (row) => (clock === "time" ? row.frame : row.frame_cost);
const isOnFront = (row) => Boolean(clock === "time" ? row.front : row.front_cost);
const clockListeners = [];

// Rows come as arrays, with their texts as indices into one list.
const scenes = data.scenes;
scenes.forEach((scene, index) => {
  const value = (name, v) => (v !== null && data.text_columns.includes(name) ? data.texts[v] : v);
  const row = (values, place) => ({ scene, place, ...Object.fromEntries(data.columns.map((name, i) => [name, value(name, values[i])])) });
  Object.assign(scene, { index, rows: data.rows[index].map(row) });
});

const addressOf = (scene, file) => `${encodeURIComponent(scene.folder)}/${encodeURIComponent(file)}`;
const pictureOf = (row, end) => addressOf(row.scene, `${row.stem}${end}.png`);

// An image from a file, with its size, so that the layout is stable while it loads.
function shot(scene, address, caption, title) {
  const [width, height] = scene.size;
  const text = `${decodeURIComponent(address)} is missing: keep the page in its folder`;
  const missing = () => img.replaceWith(el("p", { class: "missing", style: `aspect-ratio: ${width} / ${height}` }, text));
  const img = el("img", {
    class: "shot", src: address, alt: `${caption}: ${title}`, loading: "lazy", decoding: "async", width, height,
    onclick: () => enlarge(img.src, `${caption} · ${title}`), onerror: missing,
  });
  return el("figure", {}, img, el("figcaption", {}, caption));
}
const truthShot = (scene) => shot(scene, addressOf(scene, "truth.png"), "truth", scene.name);
const rowShot = (row, end, caption, title) => shot(row.scene, pictureOf(row, end), caption, title);

function enlarge(src, caption) {
  const box = byId("lightbox");
  Object.assign(box.querySelector("img"), { src, alt: caption });
  box.querySelector("figcaption").textContent = caption;
  box.showModal();
}
byId("lightbox").addEventListener("click", () => byId("lightbox").close());

// Shows a row's mask and error in the corner farther from the pointer.
function peek(row, event) {
  const box = byId("peek");
  box.hidden = !row || row.stem === null;
  if (box.hidden) return;
  box.querySelectorAll("img").forEach((img, i) => { img.src = pictureOf(row, ["", ".error"][i]); });
  box.querySelector("figcaption").textContent = `${row.scene.name}: mask and error`;
  const right = event.clientX < innerWidth / 2;
  Object.assign(box.style, { left: right ? "auto" : "1rem", right: right ? "1rem" : "auto" });
}

const CAUSES = ["acne", "gap", "leak", "edge", "penumbra"];
// Returns the causes of a row's error, each with its share in words.
function causesOf(row) {
  const all = CAUSES.map((name) => [name, row[`cause_${name}`] || 0]);
  const sum = all.reduce((total, [, part]) => total + part, 0);
  const shares = sum < 1e-6 ? [] : all.map(([name, part]) => ({ name, share: (100 * part) / sum }));
  return shares.filter(({ share }) => share >= 0.5).map((cause) => ({ ...cause, words: `${cause.name} ${cause.share.toFixed(0)} %` }));
}
const causeWords = (row) => causesOf(row).map(({ words }) => words).join(", ");

// Returns the tooltip lines of a row.
function rowLines(row) {
  const has = (v, ...lines) => (v ? lines : []);
  return [
    `${row.technique} on ${row.backend}`, row.settings,
    ...has(row.rmse !== null, `RMSE ${rmseWords(row.rmse)}; false shadow ${percent(row.false_shadow)}, false light ${percent(row.false_light)}`,
      `error from: ${causeWords(row) || "nothing"}`),
    ...has(row.frame !== null, `frame ${ms(row.frame)}: recipe ${ms(row.recipe)}, cast ${ms(row.cast)}, lookup ${ms(row.lookup)}`),
    ...has(row.scene_once, `once per scene ${ms(row.scene_once)}`), ...has(row.is_kept, "images are kept while the camera moves"),
    `counted cost ${ms(row.frame_cost)}, ${bytes(row.bytes)}`,
  ].filter(Boolean);
}
