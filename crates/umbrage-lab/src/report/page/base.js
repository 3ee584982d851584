"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const dark = matchMedia("(prefers-color-scheme: dark)");
// A smaller RMSE can't be seen: it is a fortieth of a step of an 8-bit image.
const EXACT = 1e-4;

function svgEl(tag, attributes, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) if (value !== null && value !== undefined) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  return node;
}
const plural = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
const number = (v, digits) => (v === 0 ? "0" : Math.abs(v) < 10 ** -digits ? v.toExponential(1) : v.toFixed(digits));
const percent = (v) => `${number(v, 2)} %`;
const bytes = (v) => (v >= 1e6 ? `${(v / 1e6).toFixed(1)} MB` : `${(v / 1e3).toFixed(0)} kB`);
// Three digits are what times are good for.
const short = (v) => (v === null ? "–" : v >= 100 ? v.toFixed(0) : v >= 10 ? v.toFixed(1) : v >= 0.1 ? v.toFixed(2) : number(v, 3));
const ms = (v) => (v === null ? "–" : `${short(v)} ms`);
const rmseWords = (v) => (v === null ? "–" : v < EXACT ? "exact" : number(v, 4));
const named = (row) => (row.settings ? `${row.technique}, ${row.settings}` : row.technique);
// Which of two clocks the page shows: measured time, or counted cost, which is all there is where nothing was timed.
let clock = data.clock;
const frameOf = (row) => (clock === "time" ? row.frame : row.frame_cost);
const isOnFront = (row) => Boolean(clock === "time" ? row.front : row.front_cost);
const clockListeners = [];

// Rows come as arrays, with their texts as places in one list.
function rowsOf(scene, index) {
  const isText = data.columns.map((name) => data.text_columns.includes(name));
  return data.rows[index].map((values, place) => {
    const row = { scene, place };
    data.columns.forEach((name, i) => { row[name] = isText[i] && values[i] !== null ? data.texts[values[i]] : values[i]; });
    return row;
  });
}
const scenes = data.scenes;
scenes.forEach((scene, index) => {
  scene.index = index;
  scene.rows = rowsOf(scene, index);
});

const addressOf = (scene, file) => `${encodeURIComponent(scene.folder)}/${encodeURIComponent(file)}`;
const maskOf = (row) => (row.stem === null ? null : addressOf(row.scene, `${row.stem}.png`));
const errorOf = (row) => (row.stem === null ? null : addressOf(row.scene, `${row.stem}.error.png`));
const truthOf = (scene) => addressOf(scene, "truth.png");

// A picture from a file beside the page, with its size, so that nothing moves when it comes.
function shot(scene, address, caption, title) {
  const [width, height] = scene.size;
  const img = el("img", { class: "shot", src: address, alt: `${caption}: ${title}`, loading: "lazy", decoding: "async", width, height });
  img.addEventListener("click", () => enlarge(img.src, `${caption} · ${title}`));
  img.addEventListener("error", () => img.replaceWith(missing(scene, address)));
  return el("figure", {}, img, el("figcaption", {}, caption));
}
function missing(scene, address) {
  const text = `${decodeURIComponent(address)} is missing: keep the page in its folder`;
  return el("p", { class: "missing", style: `aspect-ratio: ${scene.size[0]} / ${scene.size[1]}` }, text);
}

function enlarge(src, caption) {
  const box = byId("lightbox");
  box.querySelector("img").src = src;
  box.querySelector("img").alt = caption;
  box.querySelector("figcaption").textContent = caption;
  box.showModal();
}
byId("lightbox").addEventListener("click", () => byId("lightbox").close());

// Lines of text beside the pointer.
function tip(lines, event) {
  const box = byId("tip");
  box.hidden = !lines;
  if (box.hidden) return;
  box.replaceChildren(...lines.map((line, i) => el(i === 0 ? "b" : "span", {}, line)));
  const gap = 14;
  const { width, height } = box.getBoundingClientRect();
  const right = event.clientX + gap + width < innerWidth;
  const below = event.clientY + gap + height < innerHeight;
  const left = right ? event.clientX + gap : Math.max(4, event.clientX - gap - width);
  const top = below ? event.clientY + gap : Math.max(4, event.clientY - gap - height);
  Object.assign(box.style, { left: `${left}px`, top: `${top}px` });
}

// A row's mask and error in the corner that is farther from the pointer.
function peek(row, event) {
  const box = byId("peek");
  box.hidden = !row || row.stem === null;
  if (box.hidden) return;
  const [mask, error] = box.querySelectorAll("img");
  mask.src = maskOf(row);
  error.src = errorOf(row);
  box.querySelector("figcaption").textContent = `${row.scene.name}: mask and error`;
  const right = event.clientX < innerWidth / 2;
  Object.assign(box.style, { left: right ? "auto" : "1rem", right: right ? "1rem" : "auto" });
}

// What the pointer tells of a row.
function rowLines(row) {
  const lines = [`${row.technique} on ${row.backend}`, row.settings];
  if (row.rmse !== null) {
    lines.push(`RMSE ${rmseWords(row.rmse)}; false shadow ${percent(row.false_shadow)}, false light ${percent(row.false_light)}`);
    lines.push(`error from: ${causesOf(row).map(([name, share]) => `${name} ${share.toFixed(0)} %`).join(", ") || "nothing"}`);
  }
  if (row.frame !== null) lines.push(`frame ${ms(row.frame)}: recipe ${ms(row.recipe)}, cast ${ms(row.cast)}, lookup ${ms(row.lookup)}`);
  if (row.scene_once) lines.push(`once a scene ${ms(row.scene_once)}`);
  if (row.is_kept) lines.push("what it draws is kept while the camera moves");
  lines.push(`counted cost ${ms(row.frame_cost)}, ${bytes(row.bytes)}`);
  return lines.filter(Boolean);
}

const CAUSES = ["acne", "gap", "leak", "edge", "penumbra"];
// The causes of a row's error, each with its share of it, percent.
function causesOf(row) {
  const all = CAUSES.map((name) => [name, row[`cause_${name}`] || 0]);
  const sum = all.reduce((total, [, part]) => total + part, 0);
  return sum < 1e-6 ? [] : all.map(([name, part]) => [name, (100 * part) / sum]).filter(([, share]) => share >= 0.5);
}
function causeBar(row) {
  const parts = causesOf(row);
  const bar = el("span", { class: "causes", title: parts.map(([name, share]) => `${name} ${share.toFixed(0)} %`).join(", ") });
  for (const [name, share] of parts) bar.append(el("i", { class: name, style: `width: ${share}%` }));
  return bar;
}

function select(label, options, onchange) {
  return el("label", {}, `${label} `, el("select", { onchange: (e) => onchange(e.target.value) }, ...options.map((o) => el("option", {}, o))));
}
