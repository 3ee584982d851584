"use strict";
// The first screen: for each kind of light what to use, as words, pictures and a chart.

const HEADINGS = { hard: "Hard shadows", soft: "Soft shadows" };
const LIGHTS = { hard: "lights without extent", soft: "lights with extent" };
const timeOf = (group, setting) => (clock === "time" ? setting.time : setting.cost);
const rowOf = (group, setting) => (setting.row === null ? null : scenes[group.scene].rows[setting.row]);

function header() {
  const e = data.environment;
  const facts = [
    `umbrage ${e.version}`, e.commit && `commit ${e.commit}`, e.date && `${e.date} UTC`, `${e.cpu}, ${plural(e.threads, "thread")}`, e.system,
    e.adapter ? `adapter: ${e.adapter}` : "no graphics adapter",
  ];
  byId("environment").append(...facts.filter(Boolean).map((f) => el("span", { title: e.snapping }, f)));
  byId("notices").append(
    ...data.notices.map((n) => el("p", { class: "notice" }, n)),
    ...data.faults.map((f) => el("p", { class: "notice fault" }, f)),
  );
}

// The sentences of all backends.
function adviceOf(groups) {
  const list = el("ul", { class: "advice" });
  for (const group of groups) {
    const words = group.advice || "nothing that was compared is better than no shadow.";
    list.append(el("li", {}, el("span", { class: `badge ${group.backend}` }, group.backend), el("span", {}, words, adviceVerdicts(group))));
  }
  return list;
}

// What fails of the settings that a sentence names.
function adviceVerdicts(group) {
  const parts = [];
  for (const place of group.advised) {
    const row = rowOf(group, group.settings[place]);
    const link = row && verdictLink(row, 0);
    if (link) parts.push(parts.length ? "; " : "", el("b", {}, row.technique), " ", link);
  }
  return parts.length ? el("span", { class: "quiet verdicts" }, parts) : null;
}

// Truth and a few settings of the front, each above its error.
function strip(group) {
  const scene = scenes[group.scene];
  const rows = group.strip.map((place) => rowOf(group, group.settings[place])).filter(Boolean);
  const first = el("div", {}, shot(scene, truthOf(scene), "truth", scene.name), el("p", { class: "quiet" }, `${scene.name}, ${scene.size[0]} × ${scene.size[1]}, ${plural(scene.triangles, "triangle")}. `, el("a", { href: `#scene-${scene.index}` }, "All its rows")));
  return el("div", { class: "strip" }, first, rows.map(stripColumn));
}

function stripColumn(row) {
  if (row.stem === null) return el("div", {}, el("p", { class: "quiet" }, `${named(row)}: no picture`));
  const title = `${row.scene.name} · ${named(row)}`;
  const caption = el("button", { type: "button", class: "plain", title: row.settings, onclick: () => showRow(row) }, el("b", {}, row.technique), ` ${row.settings.split(", ").slice(0, 2).join(", ")}`);
  const time = row.frame === null ? `cost ${ms(row.frame_cost)}` : ms(row.frame);
  const error = row.rmse < EXACT ? "exact" : `RMSE ${number(row.rmse, 4)}`;
  return el("div", {}, shot(row.scene, maskOf(row), "mask", title), shot(row.scene, errorOf(row), "error", title), caption, el("p", { class: "quiet" }, `${error}, ${time}`), el("p", { class: "quiet" }, verdictLink(row, NAMED_ROWS)));
}

function groupLines(group, setting) {
  const error = setting.error < 0.001 ? "exact" : `${(100 * setting.error).toPrecision(2)} % of the error of no shadow`;
  const lines = [`${setting.technique} on ${group.backend}`, setting.settings, error];
  if (setting.time !== null) lines.push(`${setting.time.toPrecision(2)} times the time of a hard map (runs: ${setting.range.map((t) => t.toPrecision(2)).join(" – ")})`);
  lines.push(`${setting.cost.toPrecision(2)} times its counted cost`, `serves ${setting.served} of ${group.scenes} scenes`);
  const row = rowOf(group, setting);
  if (row && row.rmse !== null) lines.push(`on ${row.scene.name}: RMSE ${rmseWords(row.rmse)}, ${ms(row.frame)}`);
  return lines.filter(Boolean);
}

function settingPoint(group, setting) {
  const front = setting.front[clock === "time" ? 0 : 1];
  // Those in the pictures are named, too.
  const named = group.strip.some((place) => group.settings[place] === setting);
  return { named, x: timeOf(group, setting), y: setting.error, technique: setting.technique, backend: group.backend, front, label: labelOf(setting.technique, setting.settings), row: rowOf(group, setting), lines: () => groupLines(group, setting) };
}

function groupChart(node, current) {
  return chartOf(node, {
    height: 430, exact: 0.001, reference: 1,
    points: () => current().settings.filter((s) => s.technique !== "none").map((s) => settingPoint(current(), s)),
    xWords: () => `${clock === "time" ? "time" : "counted cost"} of a frame, hard map = 1`,
    yWords: "error, no shadow = 1",
    onclick: showRow,
  });
}

// One kind of light: sentences of all backends, then pictures and a chart of one of them.
function lightColumn(groups) {
  const { light } = groups[0];
  const state = { group: groups[0] };
  const pictures = el("div", { class: "pictures" });
  const subtitle = el("p", { class: "quiet" });
  const chart = el("div", { class: "chart" });
  const buttons = groups.map((group) => el("button", { type: "button", onclick: () => { state.group = group; show(); draw(); } }, group.backend));
  const show = () => {
    const { group } = state;
    pictures.replaceChildren(strip(group));
    subtitle.textContent = `${group.subtitle}.`;
    buttons.forEach((button, i) => button.classList.toggle("on", groups[i] === group));
  };
  const draw = groupChart(chart, () => state.group);
  show();
  const choice = groups.length > 1 ? el("div", { class: "switch", role: "group", "aria-label": "backend shown" }, buttons) : null;
  const count = plural(groups[0].scenes, "scene");
  return el("section", { class: "panel light", id: `light-${light}` }, el("h2", {}, HEADINGS[light]), el("p", { class: "quiet" }, `${LIGHTS[light]}, ${count}`),
    adviceOf(groups), pictures, el("div", { class: "chartbar" }, el("h3", {}, "Speed against accuracy"), choice), subtitle, chart);
}

// Time as measured, or cost as counted: one switch for all charts.
function clockSwitch() {
  if (data.clock !== "time") return null;
  const buttons = [["time", "measured time"], ["cost", "counted cost"]].map(([value, text]) => el("button", { type: "button", "data-clock": value, class: value === clock ? "on" : "", onclick: () => change(value) }, text));
  const change = (value) => {
    clock = value;
    buttons.forEach((b) => b.classList.toggle("on", b.dataset.clock === clock));
    clockListeners.forEach((listener) => listener());
  };
  return el("div", { class: "switch", role: "group", "aria-label": "what the charts show" }, buttons);
}

function firstScreen() {
  const lights = [...new Set(data.groups.map((g) => g.light))];
  const columns = lights.map((light) => lightColumn(data.groups.filter((g) => g.light === light)));
  return el("div", {}, el("div", { class: "chartbar" }, el("h2", {}, "What to use"), clockSwitch()),
    el("p", { class: "quiet wide" }, "The setting from which on a doubled time no longer halves the error, beside a cheaper and an exact one where there are any. Error relative to drawing no shadow, time relative to a hard map of middle size on the same backend. In the charts down and left is better: settings that no other beats in both are joined and named. Point at one for its picture; click for its row."),
    verdictSource(),
    el("div", { class: "lights" }, columns));
}

function tile(value, caption, state) {
  return el("div", { class: "tile" }, el("b", { class: state || "" }, value), el("span", {}, caption));
}

// How far counted costs may be trusted: their rank correlation with times, over scenes and backends.
function costRankTile() {
  // Small checks count in no mean, where there are frames of real size.
  const content = scenes.filter((s) => s.section === "content");
  const all = (content.length ? content : scenes).flatMap((s) => s.cost_ranks.map((r) => ({ place: `${s.name} on ${r.backend}`, correlation: r.correlation })));
  if (!all.length) return [];
  all.sort((a, b) => a.correlation - b.correlation);
  const [least, median] = [all[0], all[Math.floor(all.length / 2)]];
  return [tile(number(median.correlation, 2), `rank correlation of counted costs with times, the median over scenes and backends; least ${number(least.correlation, 2)} (${least.place})`)];
}

function tiles() {
  const rows = scenes.flatMap((s) => s.rows);
  const measured = rows.filter((r) => r.reason === null);
  const compared = rows.filter((r) => r.compared !== null);
  const sum = (name) => compared.reduce((total, r) => total + r[name], 0);
  const faults = sum("violations");
  const [held, controls] = scenes.reduce(([h, c], s) => [h + s.controls[0], c + s.controls[1]], [0, 0]);
  const largest = compared.reduce((most, r) => Math.max(most, r.largest), 0);
  const out = [tile(plural(scenes.length, "scene"), `${plural(measured.length, "row")} measured, ${rows.length - measured.length} not supported`)];
  if (compared.length) {
    const pixels = (sum("compared") - sum("undecided")).toLocaleString("en");
    out.push(
      tile(faults ? plural(faults, "fault") : "CPU = GPU", `${pixels} decided pixels compared: ${faults ? faults.toLocaleString("en") : "none"} differ`, faults ? "bad" : "good"),
      tile(sum("differing").toLocaleString("en"), `pixels differ at all; greatest difference ${number(largest, 4)}; ${sum("undecided").toLocaleString("en")} undecided`),
    );
  }
  out.push(tile(`${held} of ${controls}`, "negative controls hold: without casters masks show what is left of the light", held === controls ? "good" : "bad"));
  out.push(...costRankTile());
  return el("div", { class: "tiles" }, out);
}
