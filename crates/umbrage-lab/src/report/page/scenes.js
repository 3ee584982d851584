"use strict";
// Each scene: its chart, its truth, and its rows with their pictures.

function term(list, name, value, state) {
  list.append(el("div", {}, el("dt", {}, name), el("dd", { class: state || "" }, value)));
}

function errorTerms(list, row) {
  if (row.rmse === null) return term(list, "RMSE", "–");
  const spread = row.rmse_error ? ` ± ${number(row.rmse_error, 4)}` : "";
  term(list, "RMSE", rmseWords(row.rmse) + spread);
  term(list, "mean error", number(row.mean, 4));
  term(list, "false shadow", percent(row.false_shadow));
  term(list, "false light", percent(row.false_light));
  if (row.other_triangles) term(list, "left out: other triangles than truth", `${row.other_triangles} px`);
}

function timeTerms(list, row) {
  if (row.frame !== null) term(list, "frame", ms(row.frame));
  if (row.recipe !== null) term(list, "recipe", ms(row.recipe));
  if (row.cast !== null) term(list, "cast", ms(row.cast));
  if (row.filter !== null) term(list, "filter", ms(row.filter));
  if (row.lookup !== null) term(list, "lookup", ms(row.lookup));
  if (row.scene_once !== null) term(list, "once a scene", ms(row.scene_once));
  if (row.runs !== null) term(list, plural(row.runs, "run"), `${short(row.total_least)} – ${ms(row.total_greatest)}`);
  if (row.yardsticks !== null) term(list, "over the yardstick", `× ${number(row.yardsticks, 3)}`);
  if (row.at_unknown_clock) term(list, "no steady yardstick", "times at the device's clock of that moment");
  term(list, "counted cost", ms(row.frame_cost));
}

function mapTerms(list, row) {
  term(list, "memory", bytes(row.bytes));
  if (row.unused !== null) term(list, "texels never looked up", `${row.unused.toFixed(0)} %`);
  // Of the pixels that face the light, nine in ten: the rest graze it, and no map is fine enough for them.
  if (row.texels !== null) term(list, "texels a pixel, 9 in 10", `≥ ${number(row.texels, 2)}`);
  if (row.side !== null) term(list, "side for 1 texel a pixel", row.side.toLocaleString("en"));
}

function agreementTerms(list, row) {
  if (row.differing === null) return;
  const word = row.violations ? `${row.violations} faults` : row.differing ? `${row.differing} px, ≤ ${number(row.largest, 3)}` : "bit-equal";
  term(list, "against CPU", word, row.violations ? "bad" : "good");
  if (row.by_grid) term(list, "changed by its sub-pixel grid", `${row.by_grid} px`);
  if (row.undecided) term(list, "excused by rounding", `${row.undecided} px`);
  if (row.elsewhere) term(list, "other triangles", `${row.elsewhere} px`);
}

function figures(row) {
  const list = el("dl");
  errorTerms(list, row);
  timeTerms(list, row);
  mapTerms(list, row);
  agreementTerms(list, row);
  return list;
}

function shotsOf(row) {
  if (row.stem === null) return el("p", { class: "quiet" }, "No pictures were kept of this row.");
  const { scene, stem } = row;
  const title = `${scene.name} · ${named(row)} · ${row.backend}`;
  const extra = [];
  if (row.has_color) extra.push(shot(scene, addressOf(scene, `${stem}.color.png`), "colours", title));
  if (row.has_lookups) extra.push(shot(scene, addressOf(scene, `${stem}.lookups.png`), "the map's lookups", `${title} · dark: never looked up; blue to white: by how many pixels`));
  return el("div", { class: "shots" }, shot(scene, maskOf(row), "mask", title), shot(scene, errorOf(row), "error", title), shot(scene, truthOf(scene), "truth", scene.name), extra);
}

function causeLine(row) {
  const parts = causesOf(row);
  if (!parts.length) return null;
  const words = parts.map(([name, share]) => el("span", {}, el("i", { class: name }), `${name} ${share.toFixed(0)} %`));
  return el("div", { class: "causeline" }, "error from", causeBar(row), words);
}

function card(row) {
  const head = el("header", {}, el("h3", {}, row.technique), el("small", {}, row.settings), el("span", { class: `badge ${row.backend}` }, row.backend),
    isOnFront(row) ? el("span", { class: "badge" }, "Pareto front") : null);
  const id = `row-${row.scene.index}-${row.place}`;
  if (row.reason !== null) return el("article", { class: "panel row dash", id }, head, el("p", {}, `– ${row.reason}`));
  const same = row.same_as === null ? null : el("p", { class: "quiet" }, `Plays the same as ${row.same_as}.`);
  const link = verdictLink(row, 12);
  const verdict = link && el("p", { class: "quiet" }, "Stability: ", link);
  return el("article", { class: "panel row", id }, head, el("div", {}, shotsOf(row), causeLine(row), verdict, same), figures(row));
}

const SORTS = {
  error: (row) => row.rmse,
  time: (row) => frameOf(row),
  acne: (row) => row.cause_acne,
  memory: (row) => row.bytes,
};

function rowList(scene) {
  const state = { all: !scene.rows.some(isOnFront), backend: "all", technique: "all", sort: "error" };
  const list = el("div", { class: "rows" });
  const more = el("button", { type: "button", onclick: () => { state.all = !state.all; fill(); } });
  const isWanted = (row) => (state.all || isOnFront(row)) && (state.backend === "all" || row.backend === state.backend) && (state.technique === "all" || row.technique === state.technique);
  const key = (row) => { const v = SORTS[state.sort](row); return v === null ? Infinity : v; };
  const fill = () => {
    const shown = scene.rows.filter(isWanted).sort((a, b) => (key(a) === key(b) ? a.place - b.place : key(a) - key(b)));
    list.replaceChildren(...shown.map(card));
    more.textContent = state.all ? "Show the Pareto fronts alone" : `Show all ${scene.rows.length} rows`;
  };
  const change = (name) => (value) => { state[name] = value; fill(); };
  const values = (name) => ["all", ...new Set(scene.rows.map((r) => r[name]))];
  fill();
  clockListeners.push(fill);
  const bar = el("div", { class: "bar" }, more, select("backend", values("backend"), change("backend")),
    select("technique", values("technique"), change("technique")), select("sorted by", Object.keys(SORTS), change("sort")));
  const show = (row) => {
    if (!isWanted(row)) { Object.assign(state, { all: true, backend: "all", technique: "all" }); fill(); }
    const node = byId(`row-${scene.index}-${row.place}`);
    list.querySelectorAll(".lit").forEach((n) => n.classList.remove("lit"));
    node.classList.add("lit");
    node.scrollIntoView({ block: "center" });
  };
  return { node: el("div", {}, bar, list), show };
}

function legend() {
  const item = ([color, text]) => el("span", {}, el("i", { style: `background: ${color}` }), text);
  return el("div", { class: "legend" }, data.legend.map(item));
}

function sceneFacts(scene) {
  const t = scene.truth;
  const samples = t.largest_error > 0 ? `${plural(t.samples, "ray")} a receiver, standard error ${number(t.mean_error, 5)} (at most ${number(t.largest_error, 4)})` : "one ray a receiver";
  const leftOut = [`${t.ambiguous.toLocaleString("en")} ambiguous`, `${t.unlit.toLocaleString("en")} facing away`];
  if (t.unsampled) leftOut.push(`${t.unsampled.toLocaleString("en")} outside the sample`);
  const facts = [`${scene.light} light`, `${scene.size[0]} × ${scene.size[1]} pixels`, plural(scene.triangles, "triangle"),
    `truth: ${samples}${t.seconds === null ? "" : `, ${t.seconds.toFixed(1)} s`}`, `${t.counted.toLocaleString("en")} pixels count; left out: ${leftOut.join(", ")}`];
  const ranks = scene.cost_ranks.map((r) => `${number(r.correlation, 2)} on ${r.backend}`);
  if (ranks.length) facts.push(`rank correlation of counted costs with times: ${ranks.join(", ")}`);
  return facts;
}

// A row as a point of its scene's chart.
function rowPoint(row) {
  return { x: frameOf(row), y: row.rmse, technique: row.technique, backend: row.backend, front: isOnFront(row), label: labelOf(row.technique, row.settings), row, lines: () => rowLines(row) };
}

function sceneChart(node, scene, show) {
  const isDrawn = (row) => row.rmse !== null && row.same_as === null && row.technique !== "none";
  chartOf(node, {
    height: 460, exact: EXACT, reference: scene.rmse_of_none || null,
    points: () => scene.rows.filter(isDrawn).map(rowPoint),
    xWords: () => (clock === "time" ? `time of a frame, ms (${scene.motion})` : "counted cost of a frame, ms by the price list"),
    yWords: "RMSE of visibility",
    onclick: show,
  });
}

function fillScene(section, scene) {
  const chart = el("div", { class: "panel chart" });
  const rows = rowList(scene);
  const truth = el("div", { class: "panel truth" }, shot(scene, truthOf(scene), "truth", scene.name), legend());
  section.append(el("div", { class: "stage" }, chart, truth), rows.node);
  sceneChart(chart, scene, rows.show);
  return rows;
}

function sceneSection(scene) {
  const section = el("section", { class: "scene", id: `scene-${scene.index}` }, el("h2", {}, scene.name), el("p", { class: "lead" }, scene.summary),
    el("p", { class: "facts" }, sceneFacts(scene).map((f) => el("span", {}, f))),
    scene.nothing_compared ? el("p", { class: "notice" }, scene.nothing_compared) : null);
  section.style.minHeight = "620px";
  let rows = null;
  const fill = () => {
    if (rows) return;
    observer.disconnect();
    section.style.minHeight = "";
    rows = fillScene(section, scene);
  };
  // Charts and pictures are made when they come near the window: a report may have thousands.
  const observer = new IntersectionObserver((entries) => { if (entries.some((e) => e.isIntersecting)) fill(); }, { rootMargin: "900px" });
  observer.observe(section);
  scene.show = (row) => { fill(); rows.show(row); };
  return section;
}
const showRow = (row) => row.scene.show(row);
