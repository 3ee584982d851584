"use strict";
// The table of all rows, and the matrix of all settings by scenes.

// Rows shown at first: more would take long to lay out.
const ROWS_AT_ONCE = 100;

const text = (name, value) => ({ name, value, isText: true });
const figure = (name, key, format, title) => ({ name, value: (row) => row[key], show: (row) => (row[key] === null ? "" : format(row[key])), title });
function failedCell(row) {
  const v = verdictOf(row);
  if (!isTold(v)) return "";
  const title = verdictTitle(v, row.is_own_verdict);
  const told = `${v.failed.length} of ${v.measured}${row.is_own_verdict ? "" : "*"}`;
  return stability.href === null ? el("span", { title }, told) : el("a", { title, href: `${encodeURI(stability.href)}#${new URLSearchParams({ technique: v.technique })}`, onclick: (e) => e.stopPropagation() }, told);
}
const COLUMNS = [
  text("scene", (row) => row.scene.name),
  text("section", (row) => row.scene.section),
  text("light", (row) => `${row.scene.light}, ${row.scene.shadows}`),
  text("technique", (row) => row.technique),
  text("settings", (row) => (row.reason !== null ? `– ${row.reason}` : row.same_as !== null ? `${row.settings} (same as ${row.same_as})` : row.settings)),
  text("backend", (row) => row.backend),
  { name: "RMSE", value: (row) => row.rmse, show: (row) => rmseWords(row.rmse), title: "root of the mean square error of visibility, 0 to 1" },
  { name: "rows failed", value: (row) => { const v = verdictOf(row); return isTold(v) ? v.failed.length / v.measured : null; }, show: failedCell, title: "rows of the stability catalogue that the setting fails, of those that measure it" },
  figure("±", "rmse_error", (v) => (v ? number(v, 4) : ""), "standard error of the RMSE, where only a sample of the pixels is judged"),
  { name: "frame ms", value: frameOf, show: (row) => short(frameOf(row)), title: "what a frame takes" },
  figure("recipe ms", "recipe", short, "making the recipe, on the CPU"),
  figure("cast ms", "cast", short, "drawing maps"),
  figure("lookup ms", "lookup", short, "asking for each pixel"),
  figure("once ms", "scene_once", short, "once a scene: hierarchies and the like"),
  figure("MB", "bytes", (v) => (v / 1e6).toFixed(1), "memory held"),
  ...CAUSES.map((name) => figure(name, `cause_${name}`, (v) => (v < 5e-5 ? "" : v.toFixed(4)), `part of the mean error that comes from this: ${name}`)),
];

function isWanted(row, wanted) {
  const frame = frameOf(row);
  const words = `${row.scene.name} ${row.technique} ${row.settings} ${row.backend}`.toLowerCase();
  return (wanted.light === "all" || row.scene.shadows === wanted.light || row.scene.light === wanted.light)
    && (wanted.backend === "all" || row.backend === wanted.backend)
    && (wanted.section === "all" || row.scene.section === wanted.section)
    && (!(wanted.ms > 0) || (frame !== null && frame <= wanted.ms))
    && wanted.text.toLowerCase().split(/\s+/).every((word) => words.includes(word));
}

// Rows without a figure come last, whichever way the others are sorted.
function sorted(rows, column, isDown) {
  const sign = isDown ? -1 : 1;
  const compare = (a, b) => (column.isText ? a.localeCompare(b, "en", { numeric: true }) : a - b);
  const keyed = rows.map((row) => [row, column.value(row)]);
  keyed.sort(([, a], [, b]) => (a === null || b === null ? (a === null) - (b === null) : sign * compare(a, b)));
  return keyed.map(([row]) => row);
}

function line(row) {
  const cell = (column) => el("td", { class: column.isText ? "" : "figure" }, column.show ? column.show(row) : String(column.value(row)));
  const node = el("tr", { class: row.same_as !== null || row.reason !== null ? "faint" : "" }, COLUMNS.map(cell));
  node.addEventListener("pointermove", (e) => peek(row, e));
  node.addEventListener("pointerleave", (e) => peek(null, e));
  node.addEventListener("click", (e) => { peek(null, e); showRow(row); });
  return node;
}

function flatTable() {
  // Of equal rows the quicker come first.
  const all = sorted(scenes.flatMap((s) => s.rows), COLUMNS[9], false);
  const wanted = { text: "", light: "all", backend: "all", section: "all", ms: 0 };
  const state = { column: COLUMNS[6], isDown: false, count: ROWS_AT_ONCE };
  const body = el("tbody");
  const told = el("span");
  const more = el("button", { type: "button", onclick: () => { state.count *= 4; fill(); } });
  const heads = COLUMNS.map((column) => el("th", { class: column.isText ? "" : "figure", title: column.title }, el("button", { type: "button", class: "plain", onclick: () => sortBy(column) }, column.name)));
  const fill = () => {
    const rows = sorted(all.filter((row) => isWanted(row, wanted)), state.column, state.isDown);
    body.replaceChildren(...rows.slice(0, state.count).map(line));
    told.textContent = `${rows.length.toLocaleString("en")} of ${plural(all.length, "row")}`;
    more.hidden = rows.length <= state.count;
    more.textContent = `Show more than ${state.count}`;
    COLUMNS.forEach((column, i) => heads[i].setAttribute("aria-sort", column !== state.column ? "none" : state.isDown ? "descending" : "ascending"));
  };
  const sortBy = (column) => {
    state.isDown = state.column === column && !state.isDown;
    state.column = column;
    fill();
  };
  const change = (name) => (value) => { wanted[name] = value; fill(); };
  const input = (label, kind, name, extra) => el("label", {}, `${label} `, el("input", { type: kind, ...extra, oninput: (e) => change(name)(e.target.value) }));
  const values = (value) => ["all", ...new Set(scenes.map(value))];
  const lights = ["all", ...new Set([...scenes.map((s) => s.shadows), ...scenes.map((s) => s.light)])];
  const bar = el("div", { class: "bar" }, input("find", "search", "text", { placeholder: "scene, technique, settings", size: 24 }),
    select("light", lights, change("light")), select("backend", ["all", ...data.backends], change("backend")),
    select("section", values((s) => s.section), change("section")), input("at most", "number", "ms", { min: 0, step: "any", size: 6, placeholder: "ms" }), told);
  clockListeners.push(fill);
  fill();
  return el("section", { class: "panel", id: "rows" }, el("h2", {}, "All rows"),
    el("p", { class: "quiet" }, "Click on a column to sort, on a row for its pictures. Faint: not supported, or the same as another row. The five causes add up to the mean error. A star: the rows failed are those of the technique with the same bias and another kernel."),
    bar, el("div", { class: "scroll" }, el("table", { class: "flat" }, el("thead", {}, el("tr", {}, heads)), body)), more);
}

// One hue, light to dark, over four decades of error.
function heat(rmse) {
  const t = Math.min(1, Math.max(0, (Math.log10(Math.max(rmse, 1e-4)) + 2.7) / 2.7));
  const lightness = dark.matches ? 20 + 42 * t : 97 - 52 * t;
  const ink = dark.matches ? (t > 0.75 ? "#0c1016" : "#e8ecf2") : t > 0.6 ? "#fff" : "#1b2330";
  return `background: hsl(216 ${30 + 45 * t}% ${lightness}%); color: ${ink}`;
}

function matrixCell(row, isBest) {
  if (!row || row.rmse === null) return el("td", { class: "none", title: (row && row.reason) || "" }, "–");
  const value = row.rmse < EXACT ? "0" : row.rmse.toFixed(3).replace(/^0/, "");
  const title = `${row.scene.name}: ${named(row)}: RMSE ${rmseWords(row.rmse)}, ${ms(frameOf(row))}`;
  return el("td", { style: heat(row.rmse), class: isBest ? "best" : "", title }, value);
}

function matrixTable() {
  const backend = data.backends[0];
  const rows = scenes.flatMap((s) => s.rows).filter((r) => r.backend === backend);
  const settings = new Map(rows.map((r) => [named(r), r]));
  const bySetting = scenes.map((s) => new Map(s.rows.filter((r) => r.backend === backend).map((r) => [named(r), r])));
  // Where all are equally good there is no best.
  const best = bySetting.map((of) => {
    const all = [...of.values()].filter((r) => r.technique !== "traced" && r.rmse !== null).map((r) => r.rmse);
    return Math.min(...all) < Math.max(...all) ? Math.min(...all) : -1;
  });
  const head = el("tr", {}, el("th", {}), scenes.map((s) => el("th", {}, el("a", { href: `#scene-${s.index}` }, s.name))));
  const lines = [...settings].map(([name, key]) => el("tr", {}, el("th", {}, el("b", {}, key.technique), ` ${key.settings}`),
    bySetting.map((of, i) => { const row = of.get(name); return matrixCell(row, row && row.technique !== "traced" && row.rmse === best[i]); })));
  return el("div", {},
    el("p", { class: "quiet" }, `RMSE of visibility against truth on ${backend}, 0 to 1; the stronger the colour, the worse. Framed: the least error of a technique with a shadow map on that scene. A dash: not supported, or nothing to compare.`),
    el("div", { class: "scroll" }, el("table", { class: "matrix" }, el("thead", {}, head), el("tbody", {}, lines))));
}

// Settings by scenes; made when it is opened, as it may be large.
function matrix() {
  const box = el("details", { class: "panel" }, el("summary", {}, "Matrix of settings by scenes"));
  const fill = () => { if (box.open) box.replaceChildren(box.firstElementChild, matrixTable()); };
  box.addEventListener("toggle", fill);
  dark.addEventListener("change", fill);
  return box;
}
