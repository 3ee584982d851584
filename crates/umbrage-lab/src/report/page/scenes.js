"use strict";
// Each scene: its chart, its truth, and its rows with their images.

// Returns a row's figures as [name, value, mark], without those that have no value.
function termsOf(row) {
  const pixels = (v) => v && `${v} px`;
  const or = (v, words) => (v === null ? null : words(v));
  const times = ["frame", "recipe", "cast", "filter", "lookup"].map((name) => [name, or(row[name], ms)]);
  const against = row.violations ? `${row.violations} faults` : row.differing ? `${row.differing} px, ≤ ${number(row.largest, 3)}` : "bit-equal";
  return [
    ["RMSE", rmseWords(row.rmse) + (row.rmse_error ? ` ± ${number(row.rmse_error, 4)}` : "")],
    ["mean error", or(row.mean, (v) => number(v, 4))], ["false shadow", or(row.false_shadow, percent)], ["false light", or(row.false_light, percent)],
    ["excluded: other triangles than truth", pixels(row.other_triangles)],
    ...times, ["once per scene", or(row.scene_once, ms)],
    [plural(row.runs || 0, "run"), or(row.runs, () => `${short(row.total_least)} – ${ms(row.total_greatest)}`)],
    ["relative to the yardstick", or(row.yardsticks, (v) => `× ${number(v, 3)}`)],
    ["no steady yardstick", row.at_unknown_clock && "times are at an unknown clock of the device"],
    ["counted cost", ms(row.frame_cost)], ["memory", bytes(row.bytes)],
    ["texels never looked up", or(row.unused, (v) => `${v.toFixed(0)} %`)],
    // Nine in ten of the pixels that face the light: the others graze it, and no map is fine enough for them.
    ["texels per pixel, 9 in 10", or(row.texels, (v) => `≥ ${number(v, 2)}`)],
    ["side for 1 texel per pixel", or(row.side, (v) => v.toLocaleString("en"))],
    ["against CPU", or(row.differing, () => against), row.violations ? "bad" : "good"],
    ["changed by its sub-pixel grid", pixels(row.by_grid)], ["excused by rounding", pixels(row.undecided)], ["other triangles", pixels(row.elsewhere)],
  ].filter(([, value]) => value);
}

function shotsOf(row) {
  if (row.stem === null) return paragraph("quiet", "No images of this row were kept.");
  const title = `${row.scene.name} · ${named(row)} · ${row.backend}`;
  return el("div", { class: "shots" }, rowShot(row, "", "mask", title), rowShot(row, ".error", "error", title), truthShot(row.scene),
    row.has_color ? rowShot(row, ".color", "colours", title) : null,
    row.has_lookups ? rowShot(row, ".lookups", "the map's lookups", `${title} · dark: never looked up; blue to white: number of pixels`) : null);
}

function causeLine(row) {
  const causes = causesOf(row);
  if (!causes.length) return null;
  const bar = el("span", { class: "causes", title: causeWords(row) }, causes.map(({ name, share }) => el("i", { class: name, style: `width: ${share}%` })));
  return el("div", { class: "causeline" }, "error from", bar, causes.map(({ name, words }) => el("span", {}, el("i", { class: name }), words)));
}

function card(row) {
  const head = el("header", {}, el("h3", {}, row.technique), el("small", {}, row.settings), el("span", { class: `badge ${row.backend}` }, row.backend),
    isOnFront(row) ? el("span", { class: "badge" }, "Pareto front") : null);
  const id = `row-${row.scene.index}-${row.place}`;
  if (row.reason !== null) return el("article", { class: "panel row dash", id }, head, el("p", {}, `– ${row.reason}`));
  const verdict = verdictWords(row, 12);
  const terms = termsOf(row).map(([name, value, mark]) => el("div", {}, el("dt", {}, name), el("dd", { class: mark }, value)));
  return el("article", { class: "panel row", id }, head,
    el("div", {}, shotsOf(row), causeLine(row), verdict && paragraph("quiet", "Stability: ", verdict), row.same_as && paragraph("quiet", `Same recipe as ${row.same_as}.`)),
    el("dl", {}, terms));
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
  const more = button({ onclick: () => { state.all = !state.all; fill(); } });
  const isWanted = (row) => (state.all || isOnFront(row)) && ["backend", "technique"].every((name) => state[name] === "all" || row[name] === state[name]);
  const key = (row) => SORTS[state.sort](row) ?? Infinity;
  const fill = () => {
    const shown = scene.rows.filter(isWanted).sort((a, b) => (key(a) === key(b) ? a.place - b.place : key(a) - key(b)));
    list.replaceChildren(...shown.map(card));
    more.textContent = state.all ? "Show only the Pareto fronts" : `Show all ${scene.rows.length} rows`;
  };
  fill();
  clockListeners.push(fill);
  const values = (name) => [name, name, ["all", ...new Set(scene.rows.map((r) => r[name]))]];
  const bar = el("div", { class: "bar" }, more, controls(state, fill, [values("backend"), values("technique"), ["sorted by", "sort", Object.keys(SORTS)]]));
  const show = (row) => {
    if (!isWanted(row)) { Object.assign(state, { all: true, backend: "all", technique: "all" }); fill(); }
    list.querySelectorAll(".lit").forEach((n) => n.classList.remove("lit"));
    const node = byId(`row-${scene.index}-${row.place}`);
    node.classList.add("lit");
    node.scrollIntoView({ block: "center" });
  };
  return { node: el("div", {}, bar, list), show };
}

function sceneFacts(scene) {
  const t = scene.truth;
  const count = (v) => v.toLocaleString("en");
  const samples = t.largest_error > 0 ? `${plural(t.samples, "ray")} per receiver, standard error ${number(t.mean_error, 5)} (at most ${number(t.largest_error, 4)})` : "one ray per receiver";
  const ranks = scene.cost_ranks.map((r) => `${number(r.correlation, 2)} on ${r.backend}`).join(", ");
  return [`${scene.light} light`, `${scene.size[0]} × ${scene.size[1]} pixels`, plural(scene.triangles, "triangle"),
    `truth: ${samples}${t.seconds === null ? "" : `, ${t.seconds.toFixed(1)} s`}`,
    `${count(t.counted)} pixels count; excluded: ${count(t.ambiguous)} ambiguous, ${count(t.unlit)} facing away${t.unsampled ? `, ${count(t.unsampled)} outside the sample` : ""}`,
    ranks && `rank correlation of counted costs with times: ${ranks}`].filter(Boolean);
}

function sceneChart(node, scene, show) {
  const isDrawn = (row) => row.rmse !== null && row.same_as === null && row.technique !== "none";
  const point = (row) => ({ x: frameOf(row), y: row.rmse, technique: row.technique, settings: row.settings, backend: row.backend, front: isOnFront(row), row, lines: () => rowLines(row) });
  chartOf(node, {
    height: 460, exact: EXACT, reference: scene.rmse_of_none || null,
    points: () => scene.rows.filter(isDrawn).map(point),
    xWords: () => (clock === "time" ? `time of a frame, ms (${scene.motion})` : "counted cost of a frame by the price list, ms"),
    yWords: "RMSE of visibility",
    onclick: show,
  });
}

function fillScene(section, scene) {
  const chart = el("div", { class: "panel chart" });
  const rows = rowList(scene);
  const legend = data.legend.map(([color, text]) => el("span", {}, el("i", { style: `background: ${color}` }), text));
  const truth = el("div", { class: "panel truth" }, truthShot(scene), el("div", { class: "legend" }, legend));
  section.append(el("div", { class: "stage" }, chart, truth), rows.node);
  sceneChart(chart, scene, rows.show);
  return rows;
}

function sceneSection(scene) {
  const section = el("section", { class: "scene", id: `scene-${scene.index}`, style: "min-height: 620px" }, el("h2", {}, scene.name), paragraph("lead", scene.summary),
    paragraph("facts", sceneFacts(scene).map((f) => el("span", {}, f))), scene.nothing_compared && paragraph("notice", scene.nothing_compared));
  let rows = null;
  const fill = () => {
    if (rows) return;
    observer.disconnect();
    section.style.minHeight = "";
    rows = fillScene(section, scene);
  };
  // Charts and images are built when they come near the window: a report may have thousands.
  const observer = new IntersectionObserver((entries) => { if (entries.some((e) => e.isIntersecting)) fill(); }, { rootMargin: "900px" });
  observer.observe(section);
  scene.show = (row) => { fill(); rows.show(row); };
  return section;
}
const showRow = (row) => row.scene.show(row);
