"use strict";
// The page from top to bottom: bias, failures of each setting, the matrix, the sweeps.

// Bias window of each technique: a line each, with a bar from the least to the greatest passing offset.
function tuning() {
  const all = data.windows;
  if (!all.length) return;
  const most = Math.max(...all.filter((w) => w.passes).map((w) => w.passes[1]), 1e-9);
  const cellsOf = (window) => {
    if (!window) return [el("td"), el("td")];
    const bar = el("div", { class: "window" });
    if (window.passes) {
      const [from, to] = window.passes.map((v) => 100 * v / most);
      bar.append(el("div", { style: `margin-left: ${from}%; width: max(3px, ${to - from}%)` }));
    }
    return [el("td", {}, bar), el("td", { class: "words" }, window.words)];
  };
  const names = [...new Set(all.map((w) => w.technique))];
  const of = (name, base) => all.find((w) => w.technique === name && w.base === base);
  const lines = names.map((name) => el("tr", {}, el("th", {}, name), cellsOf(of(name, "own")), cellsOf(of(name, "bare"))));
  byId("tuning").append(el("h2", {}, "Bias tuning of each technique"), paragraph("headline", `${data.headline[0].toUpperCase()}${data.headline.slice(1)}.`),
    paragraph("soft", "The normal offsets, added to a technique's bias, at which it passes both acne under a low sun and the gap at a thin plate. A window that starts at 0 needs no tuning. A wide one tolerates a guess."),
    table("plain", [el("th", {}, "technique"), el("th", { colspan: 2 }, "added to its default bias"), el("th", { colspan: 2 }, "alone")], lines));
}

// Bar of a setting's rows by verdict.
function shares(v) {
  const parts = [["pass", v.passed], ["degraded", v.degraded.length], ["fails", v.failed.length], ["not_measured", v.not_measured], ["none", v.not_served]];
  const bar = el("div", { class: "shares" });
  for (const [name, count] of parts) if (count) bar.append(el("i", { class: name, style: `flex: ${count}`, title: `${count} ${name.replace("_", " ")}` }));
  return bar;
}

function failedRow(v, failed) {
  const cure = failed.cured_by ? ` (not with the ${failed.cured_by})` : "";
  return el("button", {
    type: "button", class: "row", title: `${failed.cases.join(", ")}${cure}`,
    onclick: () => { show({ technique: v.technique, row: String(failed.row) }); byId("all").scrollIntoView({ behavior: "smooth" }); },
  }, `${failed.title}${failed.cured_by ? "*" : ""}`);
}

function verdictLine(v) {
  const told = v.measured ? `${v.failed.length} of ${v.measured}` : "–";
  return el("tr", {}, el("th", {}, v.technique, " ", el("small", {}, shortSettings(v.settings))), el("td", {}, shares(v)), el("td", { class: "figure" }, told),
    el("td", { class: "rows" }, v.failed.map((failed) => failedRow(v, failed))));
}

function verdicts() {
  if (!data.verdicts.length) return;
  const share = (v) => v.failed.length / Math.max(1, v.measured);
  const sorted = data.verdicts.filter((v) => v.technique !== "none").sort((a, b) => share(a) - share(b) || a.degraded.length - b.degraded.length);
  byId("verdicts").append(el("h2", {}, "Failures of each setting"),
    paragraph("soft", "A row counts once, by the worst of its cases under the default fit. Bar: passed, degraded, failed, not measured (hatched), unsupported (empty). Star: passed or only degraded with the fit that moves by whole texels. Click a row for its cells."),
    table("plain", [el("th", {}, "setting"), el("th", {}, "rows"), el("th", { class: "figure" }, "fails"), el("th", {}, "rows that fail")], sorted.map(verdictLine)));
}

function lead() {
  const cells = telling.flatMap(([, result]) => result.cells);
  const count = (s) => cells.filter((c) => state(c) === s).length;
  byId("lead").textContent = `${plural(stability.cases.length, "case")} of ${new Set(stability.cases.map((c) => c.row)).size} known weaknesses, ${columns.length} settings, maps of ${stability.map_size} texels, `
    + `images of ${stability.size.join(" x ")}, ${stability.frames} frames, on ${stability.backends.join(" and ")}: ${count("pass")} pass, ${count("degraded")} degraded, ${count("fails")} fail, ${count("not_measured")} not measured.`;
  const e = data.environment;
  byId("environment").textContent = [`umbrage ${e.version}`, e.commit && `commit ${e.commit}`, e.cpu, e.system, e.adapter && `adapter: ${e.adapter}`].filter(Boolean).join(" · ");
  byId("faults").append(...stability.faults.map((f) => paragraph("fault", f)));
  byId("sanity").textContent = data.sanity || "";
}

function sweeps() {
  if (!data.sweeps.length) return;
  byId("sweeps").append(el("h2", {}, "From too little to too much"),
    paragraph("soft", "Bias: acne falls and gaps grow, each in units of its limit to pass. The best bias minimises the worse of the two. Zero is drawn at the bottom."),
    el("div", { class: "charts" }, data.sweeps.map((s) => el("figure", {}, el("a", { href: s.file }, el("img", { src: s.file, alt: s.name, loading: "lazy" }))))));
}

function main() {
  lead();
  tuning();
  verdicts();
  filterBar();
  drawMatrix();
  // Open the first failure that has an image, as an example.
  for (const [k, result] of telling) {
    const i = result.cells.findIndex((c, i) => c.technique !== "none" && state(c) === "fails" && pictures[k][i]);
    if (i >= 0) { detail(result, result.cells[i], pictures[k][i], null); break; }
  }
  sweeps();
  fromAddress();
  addEventListener("hashchange", fromAddress);
}
main();
