"use strict";
// The first screen: recommendations for each kind of light, as words, images and a chart.

const LIGHTS = { hard: ["Hard shadows", "lights without extent"], soft: ["Soft shadows", "lights with extent"] };

function header() {
  const e = data.environment;
  const facts = [
    `umbrage ${e.version}`, e.commit && `commit ${e.commit}`, e.date && `${e.date} UTC`, `${e.cpu}, ${plural(e.threads, "thread")}`, e.system,
    e.adapter ? `adapter: ${e.adapter}` : "no graphics adapter",
  ];
  byId("environment").append(...facts.filter(Boolean).map((f) => el("span", { title: e.snapping }, f)));
  byId("notices").append(...data.notices.map((n) => paragraph("notice", n)), ...data.faults.map((f) => paragraph("notice fault", f)));
}

// Returns the recommendation for a backend, and the failures of the settings that it names.
function adviceOf(group) {
  const verdicts = group.advised.map((place) => group.settings[place].shown).filter((row) => row && verdictOf(row));
  const links = verdicts.flatMap((row, i) => [i ? "; " : "", el("b", {}, row.technique), " ", verdictWords(row, 0)]);
  return el("li", {}, el("span", { class: `badge ${group.backend}` }, group.backend),
    el("span", {}, group.advice || "no compared setting is better than no shadow.", links.length ? el("span", { class: "quiet verdicts" }, links) : null));
}

// Returns truth and a few settings of the front, each mask above its error.
function strip(group) {
  const scene = scenes[group.scene];
  const rows = group.strip.map((place) => group.settings[place].shown).filter(Boolean);
  const facts = paragraph("quiet", `${scene.name}, ${scene.size[0]} × ${scene.size[1]}, ${plural(scene.triangles, "triangle")}. `, el("a", { href: `#scene-${scene.index}` }, "All its rows"));
  return el("div", { class: "strip" }, el("div", {}, truthShot(scene), facts), rows.map(stripColumn));
}

function stripColumn(row) {
  if (row.stem === null) return el("div", {}, paragraph("quiet", `${named(row)}: no image`));
  const title = `${row.scene.name} · ${named(row)}`;
  const caption = button({ class: "plain", title: row.settings, onclick: () => showRow(row) }, el("b", {}, row.technique), ` ${firstSettings(row.settings)}`);
  const time = row.frame === null ? `cost ${ms(row.frame_cost)}` : ms(row.frame);
  const error = row.rmse < EXACT ? "exact" : `RMSE ${number(row.rmse, 4)}`;
  return el("div", {}, rowShot(row, "", "mask", title), rowShot(row, ".error", "error", title), caption, paragraph("quiet", `${error}, ${time}`), paragraph("quiet", verdictWords(row, NAMED_ROWS)));
}

function groupLines(group, { technique, settings, error, time, range, cost, served, shown }) {
  const digits = (v) => v.toPrecision(2);
  return [
    `${technique} on ${group.backend}`, settings, error < 0.001 ? "exact" : `${digits(100 * error)} % of the error of no shadow`,
    time !== null && `${digits(time)} times the time of a hard map (runs: ${range.map(digits).join(" – ")})`,
    `${digits(cost)} times its counted cost`, `supports ${served} of ${group.scenes} scenes`,
    shown && shown.rmse !== null && `on ${shown.scene.name}: RMSE ${rmseWords(shown.rmse)}, ${ms(shown.frame)}`,
  ].filter(Boolean);
}

function groupChart(node, current) {
  const point = (group, setting, place) => ({
    x: clock === "time" ? setting.time : setting.cost, y: setting.error, technique: setting.technique, settings: setting.settings, backend: group.backend,
    front: setting.front[clock === "time" ? 0 : 1], row: setting.shown, lines: () => groupLines(group, setting),
    // Label the settings in the images, too.
    named: group.strip.includes(place),
  });
  return chartOf(node, {
    height: 430, exact: 0.001, reference: 1,
    points: () => current().settings.map((setting, place) => point(current(), setting, place)).filter((p) => p.technique !== "none"),
    xWords: () => `${clock === "time" ? "time" : "counted cost"} of a frame, hard map = 1`,
    yWords: "error, no shadow = 1",
    onclick: showRow,
  });
}

// Returns buttons of which one is on.
function choice(label, names, first, change) {
  const buttons = names.map(([value, words]) => button({ class: value === first ? "on" : "", onclick: (e) => {
    buttons.forEach((b) => b.classList.toggle("on", b === e.target));
    change(value);
  } }, words));
  return el("div", { class: "switch", role: "group", "aria-label": label }, buttons);
}

// Returns one kind of light: recommendations for all backends, then images and a chart of one of them.
function lightColumn(groups) {
  const { light } = groups[0];
  let current = groups[0];
  const pictures = el("div", { class: "pictures" });
  const subtitle = paragraph("quiet");
  const chart = el("div", { class: "chart" });
  const draw = groupChart(chart, () => current);
  const show = (group) => {
    current = group;
    pictures.replaceChildren(strip(group));
    subtitle.textContent = `${group.subtitle}.`;
    draw();
  };
  show(current);
  const backends = groups.length > 1 ? choice("backend shown", groups.map((group) => [group, group.backend]), current, show) : null;
  const [heading, kind] = LIGHTS[light];
  return el("section", { class: "panel light", id: `light-${light}` }, el("h2", {}, heading), paragraph("quiet", `${kind}, ${plural(groups[0].scenes, "scene")}`),
    el("ul", { class: "advice" }, groups.map(adviceOf)), pictures, el("div", { class: "chartbar" }, el("h3", {}, "Speed against accuracy"), backends), subtitle, chart);
}

function firstScreen() {
  for (const group of data.groups) for (const setting of group.settings) setting.shown = setting.row === null ? null : scenes[group.scene].rows[setting.row];
  const lights = [...new Set(data.groups.map((g) => g.light))];
  const columns = lights.map((light) => lightColumn(data.groups.filter((g) => g.light === light)));
  // Add one switch for all charts, between measured time and counted cost.
  const clocks = data.clock !== "time" ? null : choice("what the charts show", [["time", "measured time"], ["cost", "counted cost"]], clock, (value) => {
    clock = value;
    clockListeners.forEach((listener) => listener());
  });
  return el("div", {}, el("div", { class: "chartbar" }, el("h2", {}, "Recommendations"), clocks),
    paragraph("quiet wide", "The setting beyond which twice the time no longer halves the error, with a cheaper and an exact one if available. Errors are relative to drawing no shadow, times to a hard map of middle size on the same backend. In the charts down and left is better: the settings of the Pareto front are joined and named. Hover for the image; click for the row."),
    verdictSource(),
    el("div", { class: "lights" }, columns));
}

// Returns the rank correlation of counted costs with times, over scenes and backends.
function costRankTile() {
  // Exclude small checks if there are full-size scenes.
  const content = scenes.filter((s) => s.section === "content");
  const all = (content.length ? content : scenes).flatMap((s) => s.cost_ranks.map((r) => ({ place: `${s.name} on ${r.backend}`, correlation: r.correlation })));
  if (!all.length) return [];
  all.sort((a, b) => a.correlation - b.correlation);
  const [least, median] = [all[0], all[Math.floor(all.length / 2)]];
  return [[number(median.correlation, 2), `rank correlation of counted costs with times, the median over scenes and backends; least ${number(least.correlation, 2)} (${least.place})`]];
}

function tiles() {
  const rows = scenes.flatMap((s) => s.rows);
  const measured = rows.filter((r) => r.reason === null);
  const compared = rows.filter((r) => r.compared !== null);
  const sum = (name) => compared.reduce((total, r) => total + r[name], 0);
  const words = (v) => v.toLocaleString("en");
  const faults = sum("violations");
  const [held, count] = [0, 1].map((i) => scenes.reduce((total, s) => total + s.controls[i], 0));
  const largest = compared.reduce((most, r) => Math.max(most, r.largest), 0);
  const agreement = !compared.length ? [] : [
    [faults ? plural(faults, "fault") : "CPU = GPU", `${words(sum("compared") - sum("undecided"))} decided pixels compared: ${faults ? words(faults) : "none"} differ`, faults ? "bad" : "good"],
    [words(sum("differing")), `pixels differ at all; greatest difference ${number(largest, 4)}; ${words(sum("undecided"))} undecided`],
  ];
  const all = [
    [plural(scenes.length, "scene"), `${plural(measured.length, "row")} measured, ${rows.length - measured.length} not supported`], ...agreement,
    [`${held} of ${count}`, "negative controls hold: without casters masks show only the receivers' own horizon", held === count ? "good" : "bad"], ...costRankTile(),
  ];
  return el("div", { class: "tiles" }, all.map(([value, caption, state]) => el("div", { class: "tile" }, el("b", { class: state }, value), el("span", {}, caption))));
}
