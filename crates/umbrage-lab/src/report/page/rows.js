"use strict";
// The table of all rows, and the matrix of all settings by scenes.

// Number of rows shown at first: more would take long to lay out.
const ROWS_AT_ONCE = 100;

const text = (name, value) => ({ name, value, show: value, isText: true });
const column = (name, key, format, title) => ({ name, value: (row) => row[key], show: (row) => (row[key] === null ? "" : format(row[key])), title });
const failedShare = (v) => (v ? v.failed.length / v.measured : null);
function failedCell(row) {
  const v = verdictOf(row);
  return v ? verdictLink(row, `${v.failed.length} of ${v.measured}${row.is_own_verdict ? "" : "*"}`, null, {}) : "";
}
const FRAME = { name: "frame ms", value: frameOf, show: (row) => short(frameOf(row)), title: "time of a frame" };
const RMSE = { name: "RMSE", value: (row) => row.rmse, show: (row) => rmseWords(row.rmse), title: "root of the mean square error of visibility, 0 to 1" };
const COLUMNS = [
  text("scene", (row) => row.scene.name),
  text("section", (row) => row.scene.section),
  text("light", (row) => `${row.scene.light}, ${row.scene.shadows}`),
  text("technique", (row) => row.technique),
  text("settings", (row) => (row.reason !== null ? `– ${row.reason}` : row.same_as !== null ? `${row.settings} (same as ${row.same_as})` : row.settings)),
  text("backend", (row) => row.backend),
  RMSE,
  { name: "rows failed", value: (row) => failedShare(verdictOf(row)), show: failedCell, title: "rows of the stability catalogue that the setting fails, of those that measure it" },
  column("±", "rmse_error", (v) => (v ? number(v, 4) : ""), "standard error of the RMSE, if only a sample of the pixels is measured"),
  FRAME,
  column("recipe ms", "recipe", short, "making the recipe, on the CPU"),
  column("cast ms", "cast", short, "drawing maps"),
  column("lookup ms", "lookup", short, "lookup at each pixel"),
  column("once ms", "scene_once", short, "once per scene: acceleration structures and the like"),
  column("MB", "bytes", (v) => (v / 1e6).toFixed(1), "memory used"),
  ...CAUSES.map((name) => column(name, `cause_${name}`, (v) => (v < 5e-5 ? "" : v.toFixed(4)), `part of the mean error caused by: ${name}`)),
];

function isWanted(row, wanted) {
  const { name, section, shadows, light } = row.scene;
  const frame = frameOf(row);
  return ["all", shadows, light].includes(wanted.light) && ["all", row.backend].includes(wanted.backend) && ["all", section].includes(wanted.section)
    && (!(wanted.ms > 0) || (frame !== null && frame <= wanted.ms))
    && hasWords(`${name} ${row.technique} ${row.settings} ${row.backend}`, wanted.text);
}

// Sorts rows; those without a figure come last in both directions.
function sorted(rows, by, isDown) {
  const sign = isDown ? -1 : 1;
  const compare = (a, b) => (by.isText ? a.localeCompare(b, "en", { numeric: true }) : a - b);
  const keyed = rows.map((row) => [row, by.value(row)]);
  keyed.sort(([, a], [, b]) => (a === null || b === null ? (a === null) - (b === null) : sign * compare(a, b)));
  return keyed.map(([row]) => row);
}

const kindOf = ({ isText }) => (isText ? "" : "figure");
function line(row) {
  const pointers = { onpointermove: (e) => peek(row, e), onpointerleave: (e) => peek(null, e), onclick: (e) => { peek(null, e); showRow(row); } };
  return el("tr", { class: row.same_as !== null || row.reason !== null ? "faint" : "", ...pointers }, COLUMNS.map((c) => el("td", { class: kindOf(c) }, c.show(row))));
}

function flatTable() {
  // Among equal rows the faster come first.
  const all = sorted(scenes.flatMap((s) => s.rows), FRAME, false);
  const state = { text: "", light: "all", backend: "all", section: "all", ms: 0, column: RMSE, isDown: false, count: ROWS_AT_ONCE };
  const count = el("span");
  const more = button({ onclick: () => { state.count *= 4; fill(); } });
  const heads = COLUMNS.map((c) => el("th", { class: kindOf(c), title: c.title }, button({ class: "plain", onclick: () => sortBy(c) }, c.name)));
  const shown = table("flat", heads, []);
  const fill = () => {
    const rows = sorted(all.filter((row) => isWanted(row, state)), state.column, state.isDown);
    shown.querySelector("tbody").replaceChildren(...rows.slice(0, state.count).map(line));
    count.textContent = `${rows.length.toLocaleString("en")} of ${plural(all.length, "row")}`;
    more.hidden = rows.length <= state.count;
    more.textContent = `Show more than ${state.count}`;
    COLUMNS.forEach((c, i) => heads[i].setAttribute("aria-sort", c !== state.column ? "none" : state.isDown ? "descending" : "ascending"));
  };
  const sortBy = (c) => { Object.assign(state, { isDown: state.column === c && !state.isDown, column: c }); fill(); };
  const each = (...of) => ["all", ...new Set(of.flatMap((value) => scenes.map(value)))];
  const bar = el("div", { class: "bar" }, controls(state, fill, [
    ["find", "text", { type: "search", placeholder: "scene, technique, settings", size: 24 }],
    ["light", "light", each((s) => s.shadows, (s) => s.light)], ["backend", "backend", ["all", ...data.backends]], ["section", "section", each((s) => s.section)],
    ["at most", "ms", { type: "number", min: 0, step: "any", size: 6, placeholder: "ms" }]]), count);
  clockListeners.push(fill);
  fill();
  return el("section", { class: "panel", id: "rows" }, el("h2", {}, "All rows"),
    paragraph("quiet", "Click a column to sort, a row for its images. Faint: unsupported, or equal to another row. The five causes add up to the mean error. Star: the failed rows are those of the technique with the same bias and another kernel."),
    bar, shown, more);
}

// One hue, light to dark, over four decades of error.
function heat(rmse) {
  const t = Math.min(1, Math.max(0, (Math.log10(Math.max(rmse, 1e-4)) + 2.7) / 2.7));
  const lightness = dark.matches ? 20 + 42 * t : 97 - 52 * t;
  const ink = dark.matches ? (t > 0.75 ? "#0c1016" : "#e8ecf2") : t > 0.6 ? "#fff" : "#1b2330";
  return `background: hsl(216 ${30 + 45 * t}% ${lightness}%); color: ${ink}`;
}

function matrixCell(row, best) {
  if (!row || row.rmse === null) return el("td", { class: "none", title: (row && row.reason) || "" }, "–");
  const value = row.rmse < EXACT ? "0" : row.rmse.toFixed(3).replace(/^0/, "");
  const title = `${row.scene.name}: ${named(row)}: RMSE ${rmseWords(row.rmse)}, ${ms(frameOf(row))}`;
  return el("td", { style: heat(row.rmse), class: row.technique !== "traced" && row.rmse === best ? "best" : "", title }, value);
}

function matrixTable() {
  const backend = data.backends[0];
  const columns = scenes.map((scene) => {
    const rows = scene.rows.filter((r) => r.backend === backend);
    const errors = rows.filter((r) => r.technique !== "traced" && r.rmse !== null).map((r) => r.rmse);
    // If all are equal, no row is marked as the best.
    const best = Math.min(...errors) < Math.max(...errors) ? Math.min(...errors) : -1;
    return { scene, best, rows: new Map(rows.map((r) => [named(r), r])) };
  });
  const settings = new Map(columns.flatMap(({ rows }) => [...rows]));
  const head = [el("th", {}), columns.map(({ scene: s }) => el("th", {}, el("a", { href: `#scene-${s.index}` }, s.name)))];
  const lines = [...settings].map(([name, key]) => el("tr", {}, el("th", {}, el("b", {}, key.technique), ` ${key.settings}`), columns.map(({ rows, best }) => matrixCell(rows.get(name), best))));
  return el("div", {},
    paragraph("quiet", `RMSE of visibility against truth on ${backend}, 0 to 1; the stronger the colour, the worse. Framed: the least error on that scene, except for ray tracing. Dash: unsupported, or nothing to compare.`),
    table("matrix", head.flat(), lines));
}

// The matrix of settings by scenes; built when it is opened, as it may be large.
function matrix() {
  const box = el("details", { class: "panel" }, el("summary", {}, "Matrix of settings by scenes"));
  const fill = () => { if (box.open) box.replaceChildren(box.firstElementChild, matrixTable()); };
  box.addEventListener("toggle", fill);
  dark.addEventListener("change", fill);
  return box;
}
