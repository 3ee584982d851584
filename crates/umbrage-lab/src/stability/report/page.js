"use strict";
// Everything is built from text nodes, never from HTML strings, so no name can smuggle in markup.
const { stability, pictures, sweeps, windows, sanity } = JSON.parse(document.getElementById("data").textContent);
const byId = (id) => document.getElementById(id);

function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) node.setAttribute(key, value);
  }
  node.append(...children.filter((c) => c !== null && c !== undefined));
  return node;
}
const number = (v) => (v === 0 ? "0" : Math.abs(v) < 1e-3 ? v.toExponential(1) : v.toPrecision(3));
const withUnit = (v, unit) => `${number(v)}${unit ? ` ${unit}` : ""}`;
const signs = { pass: "✓", not_measured: "·", degraded: "~", fails: "✗" };
const key = (cell) => `${cell.technique} (${cell.settings})`;

// The fit is the line's, not the column's.
for (const result of stability.cases) {
  if (result.fit) for (const cell of result.cells) cell.settings = cell.settings.replace(`, ${result.fit}`, "");
}

// Columns: every setting of any case, each once, in order; extra settings of single cases come last of their technique.
const columns = [];
for (const cell of stability.cases.flatMap((c) => c.cells)) if (!columns.some((c) => key(c) === key(cell))) columns.push(cell);
const order = [...new Set(columns.map((c) => c.technique))];
columns.sort((a, b) => order.indexOf(a.technique) - order.indexOf(b.technique));

function state(cell) {
  if (cell.outcome.measured) return cell.outcome.measured.verdict;
  return cell.outcome.fault ? "fault" : "none";
}
const sign = (cell) => signs[state(cell)] || (state(cell) === "fault" ? "!" : "–");

function says(result, cell) {
  const o = cell.outcome;
  if (o.fault) return o.fault.what;
  if (o.unsupported) return `not made for it: ${o.unsupported.reason}`;
  return o.measured.judgements.map((judgement, k) => judged(result.criteria[k], judgement)).join("; ");
}

function judged(criterion, judgement) {
  if (judgement.figure === null) return `${criterion.measure}: not measured: ${judgement.reason}`;
  const { pass, fails } = criterion.limits;
  const unit = criterion.unit;
  return `${criterion.measure}: ${withUnit(judgement.figure, unit)} ${signs[judgement.verdict]} (passes up to ${withUnit(pass, unit)}, fails above ${withUnit(fails, unit)})`;
}

function tip(event, text) {
  const box = byId("tip");
  box.textContent = text;
  box.hidden = !text;
  if (!text) return;
  const { left, bottom } = event.target.getBoundingClientRect();
  box.style.left = `${Math.min(left, innerWidth - box.offsetWidth - 12)}px`;
  box.style.top = `${Math.min(bottom + 6, innerHeight - box.offsetHeight - 8)}px`;
}

function detail(result, cell, picture, button) {
  document.querySelectorAll(".chosen").forEach((b) => b.classList.remove("chosen"));
  if (button) button.classList.add("chosen");
  const moving = result.motion !== "still";
  const caption = moving
    ? "The first frames' masks at points that stay, then where they change: orange."
    : "Truth, mask, error: blue is false shadow, orange is false light.";
  const agreement = cell.disagreeing === null ? null
    : el("p", { class: "soft" }, cell.disagreeing ? `Backends differ on ${cell.disagreeing} decided pixels.` : "Backends agree.");
  const box = byId("detail");
  box.hidden = false;
  const parts = [
    el("h3", {}, `${result.row} ${result.title}: ${result.case}, ${cell.technique}`),
    el("p", {}, `${sign(cell)} ${says(result, cell)}`),
    el("p", { class: "soft" }, `Settings: ${cell.settings}${result.fit ? `, ${result.fit}` : ""}. Scene: ${result.scene}, ${result.motion}. A perfect map of ${stability.map_size} texels shows ${result.criteria.map((c) => `${c.measure} ${withUnit(c.ideal, c.unit)}`).join(", ")}.`),
    el("p", { class: "soft" }, `What fails: ${result.weakness}. Limits: ${result.criteria.map((c) => `${c.measure}: ${c.reason}`).join(". ")}.`),
    agreement,
    picture ? el("img", { src: picture, alt: `${result.case}: ${key(cell)}` }) : el("p", { class: "soft" }, "No picture: it passes, is not measured, or has none to show."),
    picture ? el("p", { class: "soft" }, caption) : null,
  ];
  box.replaceChildren(...parts.filter((part) => part !== null));
}

function cellOf(result, k, column) {
  const i = result.cells.findIndex((c) => key(c) === key(column));
  if (i < 0) return el("td", {});
  const cell = result.cells[i];
  const text = `${key(cell)}. ${says(result, cell)}`;
  const button = el("button", {
    class: `cell ${state(cell)}`, "aria-label": text,
    onmouseenter: (e) => tip(e, text), onmouseleave: (e) => tip(e, ""), onfocus: (e) => tip(e, text), onblur: (e) => tip(e, ""),
    onclick: () => { detail(result, cell, pictures[k][i], button); byId("detail").scrollIntoView({ behavior: "smooth", block: "nearest" }); },
  }, sign(cell));
  return el("td", {}, button);
}

function matrix() {
  const short = (c) => `${c.technique}, ${c.settings.includes("bias: ") ? c.settings.split("bias: ").pop() : c.settings}`;
  const head = el("tr", {}, el("th", { class: "wide" }), el("th", { class: "wide" }, "case"), el("th", { class: "wide" }, "measure"),
    ...columns.map((c) => el("th", { title: key(c) }, el("div", {}, short(c)))));
  const telling = [...stability.cases.entries()].filter(([, result]) => !result.is_sanity);
  const rows = telling.map(([k, result], line) => {
    const first = line === 0 || telling[line - 1][1].row !== result.row;
    const yet = result.not_yet ? ` · ${result.not_yet}: no such technique yet` : "";
    return el("tr", { class: first ? "first" : null },
      el("td", { class: "number" }, first ? String(result.row) : ""),
      el("th", { title: `${result.title}: ${result.weakness}${yet}` }, result.case, " ", el("small", {}, result.title)),
      el("td", { class: "measure" }, result.criteria.map((c) => `${c.measure} ≤ ${withUnit(c.limits.pass, c.unit)}`).join(", ")),
      ...columns.map((c) => cellOf(result, k, c)));
  });
  byId("sanity").textContent = sanity || "";
  byId("matrix").append(el("thead", {}, head), el("tbody", {}, ...rows));
}

// How much tuning each technique needs: a line for each, a bar from the least to the greatest offset that passes.
function tuning() {
  if (!stability.windows.length) return;
  const most = Math.max(...stability.windows.filter((w) => w.passes).map((w) => w.passes[1]), 1e-9);
  const names = [...new Set(stability.windows.map((w) => w.technique))];
  const of = (name, base) => {
    const i = stability.windows.findIndex((w) => w.technique === name && w.base === base);
    if (i < 0) return [el("td"), el("td")];
    const passes = stability.windows[i].passes;
    const bar = el("div", { class: "bar" });
    if (passes) {
      const [from, to] = passes.map((v) => 100 * v / most);
      bar.append(el("div", { style: `margin-left: ${from}%; width: max(3px, ${to - from}%)` }));
    }
    return [el("td", {}, bar), el("td", { class: "measure" }, windows[i])];
  };
  byId("tuning").append(el("h2", {}, "How much tuning each technique needs"),
    el("p", { class: "soft" }, "The normal offsets, added to a technique's bias, at which it passes both acne under a low sun and the gap at a thin plate. A window that starts at 0 needs no tuning; a wide one forgives a guess."),
    el("div", { class: "scroll" }, el("table", {},
      el("thead", {}, el("tr", {}, el("th", { class: "flat" }, "technique"), el("th", { class: "flat", colspan: 2 }, "added to its default bias"), el("th", { class: "flat", colspan: 2 }, "alone"))),
      el("tbody", {}, ...names.map((name) => el("tr", {}, el("th", {}, name), ...of(name, "own"), ...of(name, "bare")))))));
}

function main() {
  tuning();
  const cells = stability.cases.filter((c) => !c.is_sanity).flatMap((c) => c.cells);
  const count = (s) => cells.filter((c) => state(c) === s).length;
  byId("lead").textContent = `${stability.cases.length} cases of ${new Set(stability.cases.map((c) => c.row)).size} known weaknesses, ${columns.length} settings, maps of ${stability.map_size} texels, `
    + `pictures of ${stability.size.join(" x ")}, ${stability.frames} frames, on ${stability.backends.join(" and ")}: ${count("pass")} pass, ${count("degraded")} degraded, ${count("fails")} fail, ${count("not_measured")} not measured.`;
  byId("faults").append(...stability.faults.map((f) => el("p", { class: "fault" }, f)));
  matrix();
  // The first failure that has a picture stands open, so that a stranger sees what a picture shows.
  for (const [k, result] of stability.cases.entries()) {
    const i = result.cells.findIndex((c, i) => state(c) === "fails" && pictures[k][i]);
    if (i >= 0) { detail(result, result.cells[i], pictures[k][i], null); break; }
  }
  if (!sweeps.length) return;
  byId("sweeps").append(el("h2", {}, "From too little to too much"),
    el("p", { class: "soft" }, "Bias: acne falls and gaps grow, each in units of the limit that passes; best where the worse of the two is least. What is 0 is drawn at the bottom."),
    el("div", { class: "charts" }, ...sweeps.map((s) => el("figure", {}, el("img", { src: s.svg, alt: s.name })))));
}
main();
