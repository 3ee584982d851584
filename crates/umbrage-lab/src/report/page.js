"use strict";
// Everything but the charts is built from text nodes, never from strings of markup, so no name can smuggle in any.
const data = JSON.parse(document.getElementById("data").textContent);
const { comparison, pages, images } = data;
const dark = matchMedia("(prefers-color-scheme: dark)");

function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.filter((c) => c !== null && c !== undefined));
  return node;
}
const byId = (id) => document.getElementById(id);
const plural = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;
const number = (v, digits) => (v === 0 ? "0" : v < 10 ** -digits ? v.toExponential(1) : v.toFixed(digits));
const percent = (v) => `${number(v, 2)} %`;
const bytes = (v) => (v >= 1e6 ? `${(v / 1e6).toFixed(1)} MB` : `${(v / 1e3).toFixed(0)} kB`);
const ms = (s) => (s ? `${number(s.median, 2)} ms` : "–");
// Which of the two clocks the charts show; the page falls back to counted cost where nothing was timed.
let clock = data.overall.some((g) => g.charts.time) || pages.some((p) => p.charts.time) ? "time" : "cost";
const charts = [];
const range = (s) => `${number(s.least, 2)} – ${number(s.greatest, 2)} ms`;
const measured = (row) => row.outcome.measured || null;
// Where no pixel counts a row has no errors.
const rmseOf = (row) => { const m = measured(row); return m && m.errors ? m.errors.rmse : null; };

function shot(id, caption, title) {
  const img = el("img", { class: "shot", src: images[id], alt: `${caption}: ${title}`, loading: "lazy", decoding: "async" });
  img.addEventListener("click", () => enlarge(img.src, `${caption} · ${title}`));
  return el("figure", {}, img, el("figcaption", {}, caption));
}

function enlarge(src, caption) {
  const box = byId("lightbox");
  box.querySelector("img").src = src;
  box.querySelector("img").alt = caption;
  box.querySelector("figcaption").textContent = caption;
  box.showModal();
}
byId("lightbox").addEventListener("click", () => byId("lightbox").close());

function header() {
  const e = comparison.environment;
  const facts = [
    `umbrage ${e.version}`, e.commit && `commit ${e.commit}`, e.date && `${e.date} UTC`, `${e.cpu}, ${plural(e.threads, "thread")}`, e.system,
    e.adapter ? `adapter: ${e.adapter}` : "no graphics adapter", e.snapping,
  ];
  byId("environment").append(...facts.filter(Boolean).map((f) => el("span", {}, f)));
  byId("notices").append(
    ...comparison.notices.map((n) => el("p", { class: "notice" }, n)),
    ...data.faults.map((f) => el("p", { class: "notice fault" }, f)),
  );
}

function tile(value, caption, state) {
  return el("div", { class: "tile" }, el("b", { class: state || "" }, value), el("span", {}, caption));
}

function tiles() {
  const scenes = comparison.scenes;
  const rows = scenes.flatMap((s) => s.rows);
  const compared = rows.map(measured).filter((m) => m && m.agreement).map((m) => m.agreement);
  const sum = (f) => compared.reduce((total, a) => total + f(a), 0);
  const violations = sum((a) => a.violations);
  const controls = scenes.flatMap((s) => s.controls);
  const held = controls.filter((c) => c.holds).length;
  const largest = compared.reduce((most, a) => Math.max(most, a.largest), 0);
  const out = [
    tile(plural(scenes.length, "scene"), `${plural(rows.filter(measured).length, "row")} measured, ${rows.filter((r) => !measured(r)).length} not supported`),
  ];
  if (compared.length) {
    const pixels = sum((a) => a.compared - a.undecided);
    out.push(
      tile(violations ? plural(violations, "fault") : "CPU = GPU", `${pixels.toLocaleString("en")} decided pixels compared: ${violations ? violations.toLocaleString("en") : "none"} differ`, violations ? "bad" : "good"),
      tile(sum((a) => a.differing).toLocaleString("en"), `pixels differ at all; greatest difference ${number(largest, 4)}; ${sum((a) => a.undecided).toLocaleString("en")} undecided`),
    );
  }
  out.push(tile(`${held} of ${controls.length}`, "negative controls hold: without casters masks show what is left of the light", held === controls.length ? "good" : "bad"));
  return el("div", { class: "tiles" }, ...out);
}

// One hue, light to dark, over four decades of error.
function heat(rmse) {
  const t = Math.min(1, Math.max(0, (Math.log10(Math.max(rmse, 1e-4)) + 2.7) / 2.7));
  const lightness = dark.matches ? 20 + 42 * t : 97 - 52 * t;
  const ink = dark.matches ? (t > 0.75 ? "#0c1016" : "#e8ecf2") : t > 0.6 ? "#fff" : "#1b2330";
  return `background: hsl(216 ${30 + 45 * t}% ${lightness}%); color: ${ink}`;
}

function matrix() {
  const scenes = comparison.scenes;
  const backend = scenes[0].rows.length ? scenes[0].rows[0].backend : "";
  // Not by slug: that is shorter where a technique has one setting.
  const label = (r) => `${r.technique} ${r.settings}`;
  const keys = new Map();
  scenes.forEach((s) => s.rows.filter((r) => r.backend === backend).forEach((r) => keys.set(label(r), r)));
  const find = (s, name) => s.rows.find((r) => label(r) === name && r.backend === backend);
  const raster = (r) => r.technique !== "traced" && measured(r);
  // Where all are equally good there is no best.
  const best = scenes.map((s) => {
    const all = s.rows.filter((r) => r.backend === backend && raster(r)).map(rmseOf).filter((e) => e !== null);
    return Math.min(...all) < Math.max(...all) ? Math.min(...all) : -1;
  });
  const head = el("tr", {}, el("th", {}), ...scenes.map((s, i) => el("th", {}, el("a", { href: `#scene-${i}` }, s.name))));
  const lines = [...keys.values()].map((key) => {
    const cells = scenes.map((s, i) => {
      const row = find(s, label(key));
      const m = row && measured(row);
      if (!m) return el("td", { class: "none", title: row ? row.outcome.unsupported.reason : "" }, "–");
      const rmse = rmseOf(row);
      if (rmse === null) return el("td", { class: "none", title: s.nothing_compared }, "–");
      const title = `${s.name}: ${row.technique}, ${row.settings}: RMSE ${number(rmse, 4)}, ${ms(m.times && m.times.total) === "–" ? `cost ${number(m.cost_ms, 2)} ms` : ms(m.times.total)}`;
      const text = rmse === 0 ? "0" : rmse.toFixed(3).replace(/^0/, "");
      return el("td", { style: heat(rmse), class: raster(row) && rmse === best[i] ? "best" : "", title }, text);
    });
    return el("tr", {}, el("th", {}, el("b", {}, key.technique), ` ${key.settings}`), ...cells);
  });
  return el("div", { class: "panel" },
    el("h2", {}, "All scenes"),
    el("p", {}, `RMSE of visibility against truth on ${backend}, 0 to 1; the stronger the colour, the worse. Framed: the least error of a technique with a shadow map on that scene. A dash: not supported, or nothing to compare; hover for the reason.`),
    el("div", { class: "scroll" }, el("table", { class: "matrix" }, el("thead", {}, head), el("tbody", {}, ...lines))));
}

// How far from a point the pointer finds it, in units of the drawing.
const REACH = 24;

// The drawing comes with the data, as markup with all names escaped; scripts within a document parsed like this never run.
function drawing(chart) {
  const parsed = new DOMParser().parseFromString(chart.svg, "image/svg+xml");
  const svg = document.importNode(parsed.documentElement, true);
  // Ends of the axes clip nothing of ours, and clips of several drawings in one page would have one name.
  svg.querySelectorAll("[clip-path]").forEach((node) => node.removeAttribute("clip-path"));
  svg.querySelectorAll("defs").forEach((node) => node.remove());
  return svg;
}

// The points of a drawing: the group that draws each, what it is, and its place. Both axes are logarithmic.
function pointsOf(svg, chart) {
  const front = new Set(chart.front);
  const attribute = (name) => Number(svg.getAttribute(`data-${name}`));
  const along = (value, least, greatest, start, end) => start + (Math.log(value / least) / Math.log(greatest / least)) * (end - start);
  const points = [];
  for (const group of svg.querySelectorAll("g.tt")) {
    const title = group.querySelector("title");
    if (!title) continue;
    const dot = chart.dots[title.textContent];
    // A browser would show it beside our own text.
    title.remove();
    if (!dot) continue;
    const x = along(Number(group.dataset.x), attribute("xmin"), attribute("xmax"), attribute("plot-left"), attribute("plot-right"));
    const y = along(Number(group.dataset.y), attribute("ymin"), attribute("ymax"), attribute("plot-bottom"), attribute("plot-top"));
    group.classList.toggle("faint", !front.has(dot.place));
    points.push({ group, dot, x, y });
  }
  return points;
}

// Entries of the legend mute and show what they name: a technique, or a backend with its front. A double click shows it alone.
function legendOf(svg, points, muted) {
  const entries = [...svg.querySelectorAll("g.legend-entry")];
  const lines = [...svg.querySelectorAll("g.tt[data-group]")];
  const name = (node) => node.dataset.group;
  const front = (dot) => `Pareto front, ${dot.backend}`;
  const isMuted = (dot) => muted.has(dot.technique) || muted.has(front(dot));
  const update = () => {
    points.forEach((p) => p.group.classList.toggle("muted", isMuted(p.dot)));
    lines.forEach((line) => line.classList.toggle("muted", muted.has(name(line))));
    entries.forEach((entry) => {
      entry.classList.toggle("muted", muted.has(name(entry)));
      entry.setAttribute("aria-pressed", !muted.has(name(entry)));
    });
  };
  const toggle = (entry) => {
    if (!muted.delete(name(entry))) muted.add(name(entry));
    update();
  };
  const isFront = (entry) => name(entry).startsWith("Pareto front, ");
  const alone = (entry) => {
    const others = entries.filter((other) => other !== entry && isFront(other) === isFront(entry));
    const wasAlone = others.every((other) => muted.has(name(other)));
    muted.delete(name(entry));
    others.forEach((other) => (wasAlone ? muted.delete(name(other)) : muted.add(name(other))));
    update();
  };
  for (const entry of entries) {
    const box = entry.getBBox();
    entry.prepend(rectangle(box.x - 4, box.y - 2, box.width + 8, box.height + 4));
    entry.setAttribute("role", "button");
    entry.setAttribute("tabindex", "0");
    entry.addEventListener("click", () => toggle(entry));
    entry.addEventListener("dblclick", () => alone(entry));
    entry.addEventListener("keydown", (e) => {
      if (e.key !== "Enter" && e.key !== " ") return;
      e.preventDefault();
      if (e.shiftKey) alone(entry);
      else toggle(entry);
    });
  }
  update();
  return isMuted;
}

function rectangle(x, y, width, height) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  for (const [key, value] of Object.entries({ x, y, width, height, class: "area" })) node.setAttribute(key, value);
  return node;
}

// Dragging over a chart magnifies the part dragged over; a double click or Escape shows the whole again. Markers keep their size, so that what lies close comes apart. Answers what the pointer is doing: how strongly the chart is magnified, and whether the last press was a drag.
function magnifierOf(svg, points) {
  const whole = svg.viewBox.baseVal;
  const full = { x: 0, y: 0, width: whole.width, height: whole.height };
  const state = { scale: 1, dragged: false };
  let from = null;
  let frame = null;
  const at = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  const show = (view) => {
    state.scale = full.width / view.width;
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.width} ${view.height}`);
    svg.classList.toggle("magnified", state.scale > 1);
    for (const { group, x, y } of points) {
      const keep = `translate(${x} ${y}) scale(${1 / state.scale}) translate(${-x} ${-y})`;
      // Lines are error bars: their ends are values.
      group.querySelectorAll(":scope > :not(line)").forEach((marker) => marker.setAttribute("transform", keep));
    }
  };
  const box = (a, b) => ({ x: Math.min(a.x, b.x), y: Math.min(a.y, b.y), width: Math.abs(a.x - b.x), height: Math.abs(a.y - b.y) });
  const end = () => {
    if (frame) frame.remove();
    from = frame = null;
  };
  svg.addEventListener("pointerdown", (e) => {
    state.dragged = false;
    // A finger scrolls.
    if (e.pointerType === "mouse" && e.button === 0 && !e.target.closest(".legend-entry")) from = at(e);
  });
  svg.addEventListener("pointermove", (e) => {
    if (!from) return;
    const { x, y, width, height } = box(from, at(e));
    if (!frame && Math.max(width, height) * state.scale < 8) return;
    if (!frame) {
      svg.setPointerCapture(e.pointerId);
      state.dragged = true;
    }
    if (frame) frame.remove();
    frame = rectangle(x, y, width, height);
    frame.setAttribute("class", "frame");
    svg.append(frame);
  });
  svg.addEventListener("pointerup", (e) => {
    const part = from && frame && box(from, at(e));
    end();
    if (!part) return;
    // The part grows to the shape of the whole, about its centre.
    const width = Math.max(part.width, (part.height * full.width) / full.height, full.width / 64);
    const height = (width * full.height) / full.width;
    show({ x: part.x + (part.width - width) / 2, y: part.y + (part.height - height) / 2, width, height });
  });
  svg.addEventListener("pointercancel", end);
  svg.addEventListener("dblclick", (e) => { if (!e.target.closest(".legend-entry")) show(full); });
  svg.setAttribute("tabindex", "-1");
  svg.addEventListener("keydown", (e) => { if (e.key === "Escape") show(full); });
  return state;
}

// A chart that follows the clock. `picture` gives the number of a row's picture.
function chartOf(node, both, onclick, picture) {
  const muted = new Set();
  const draw = () => {
    const chart = both[clock] || both.cost;
    if (!chart) return;
    const svg = drawing(chart);
    node.replaceChildren(svg);
    const points = pointsOf(svg, chart);
    const isMuted = legendOf(svg, points, muted);
    const magnifier = magnifierOf(svg, points);
    const nearest = (event) => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      const distance = (p) => Math.hypot(p.x - at.x, p.y - at.y);
      const near = points.filter((p) => !isMuted(p.dot) && distance(p) * magnifier.scale < REACH);
      // Of two points in one place the later is drawn above the other.
      return near.reduce((best, p) => (best && distance(best) < distance(p) ? best : p), null);
    };
    let lit = null;
    const light = (point, event) => {
      if (lit) lit.group.classList.remove("lit");
      lit = point;
      if (lit) lit.group.classList.add("lit");
      svg.classList.toggle("near", lit !== null);
      tip(lit && lit.dot.hover, event);
      peek(lit && picture(lit.dot.place), event);
    };
    svg.addEventListener("pointermove", (e) => light(nearest(e), e));
    svg.addEventListener("pointerleave", (e) => light(null, e));
    svg.addEventListener("click", (e) => {
      const point = e.target.closest(".legend-entry") ? null : nearest(e);
      if (point && !magnifier.dragged) onclick(point.dot.place);
    });
  };
  draw();
  charts.push(draw);
}

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

// A row's mask beside the pointer.
function peek(id, event) {
  const box = byId("peek");
  box.hidden = id === null || id === undefined;
  if (box.hidden) return;
  box.src = images[id];
  const right = event.clientX < innerWidth / 2;
  Object.assign(box.style, { top: `${Math.max(8, event.clientY - 190)}px`, left: right ? "auto" : "1.5rem", right: right ? "1.5rem" : "auto" });
}

// Time as measured, or cost as counted: one switch for all charts.
function clockSwitch() {
  const both = pages.some((p) => p.charts.time) && pages.some((p) => p.charts.cost);
  if (!both) return null;
  const option = (value, text) => el("button", { type: "button", class: value === clock ? "on" : "", "data-clock": value, onclick: () => {
    clock = value;
    document.querySelectorAll("[data-clock]").forEach((b) => b.classList.toggle("on", b.dataset.clock === clock));
    charts.forEach((draw) => draw());
  } }, text);
  return el("div", { class: "switch", role: "group", "aria-label": "what the charts show" }, option("time", "measured time"), option("cost", "counted cost"));
}

function overallChart() {
  if (!data.overall.length) return null;
  const panel = el("div", { class: "panel" }, el("h2", {}, "Speed against accuracy"),
    el("p", {}, `Every setting, mean over the scenes: error relative to drawing no shadows (1: as wrong as none), time of a frame relative to hard shadows from a map of middle size. Down and left is better; what no other setting beats at both is joined by the dashed line, the rest is faint. Click on the legend to hide a technique, twice to see it alone; drag to magnify, double-click for the whole. Where a technique cannot serve a scene it counts as drawing no shadow there.`),
    clockSwitch());
  for (const group of data.overall) {
    const chart = el("div", { class: "chart whole" });
    panel.append(el("h3", {}, group.title), el("p", {}, group.subtitle), chart);
    requestAnimationFrame(() => chartOf(chart, group.charts, () => {}, () => null));
  }
  return panel;
}

function term(list, name, value, state) {
  list.append(el("dt", {}, name), el("dd", { class: state || "" }, value));
}

function figures(m) {
  const list = el("dl");
  const { errors: e, times: t, agreement: a } = m;
  if (e) {
    term(list, "RMSE", number(e.rmse, 4));
    term(list, "mean error", number(e.mean, 4));
    term(list, "false shadow", percent(e.false_shadow));
    term(list, "false light", percent(e.false_light));
    term(list, "acne off edges", percent(e.acne));
    if (e.elsewhere) term(list, "left out: sees other triangles than truth", `${e.elsewhere} px`);
  } else {
    term(list, "RMSE", "–");
  }
  if (t) {
    term(list, "cast", ms(t.cast));
    if (t.filter) term(list, "filter", ms(t.filter));
    term(list, "lookup", ms(t.receive));
    term(list, "total, median", ms(t.total));
    term(list, plural(t.total.runs, "run"), range(t.total));
    if (t.ratio) term(list, "over the yardstick", `× ${number(t.ratio.median, 3)}`);
  }
  term(list, "counted cost", `${number(m.cost_ms, 2)} ms`);
  term(list, "memory", bytes(m.bytes));
  if (m.maps) {
    term(list, "texels never looked up", `${(100 * m.maps.unused).toFixed(0)} %`);
    // Of the pixels that face the light, nine in ten: the rest graze it, and no map is fine enough for them.
    if (m.maps.texels !== null) term(list, "texels a pixel, 9 in 10", `≥ ${number(m.maps.texels, 2)}`);
    if (m.maps.side !== null) term(list, "side for 1 texel a pixel", m.maps.side.toLocaleString("en"));
  }
  if (a) {
    const word = a.violations ? `${a.violations} faults` : a.differing ? `${a.differing} px, ≤ ${number(a.largest, 3)}` : "bit-equal";
    term(list, "against CPU", word, a.violations ? "bad" : "good");
    if (a.by_grid) term(list, "changed by its sub-pixel grid", `${a.by_grid} px`);
    if (a.undecided) term(list, "excused by rounding", `${a.undecided} px`);
    if (a.elsewhere) term(list, "other triangles", `${a.elsewhere} px`);
  }
  return list;
}

function card(scene, page, index, onFront) {
  const row = scene.rows[index];
  const m = measured(row);
  const head = el("header", {}, el("h3", {}, row.technique), el("small", {}, row.settings), el("span", { class: `badge ${row.backend}` }, row.backend),
    onFront ? el("span", { class: "badge" }, "Pareto front") : null);
  const id = `row-${page.index}-${index}`;
  if (!m) return el("article", { class: "panel row dash", id }, head, el("p", {}, `– ${row.outcome.unsupported.reason}`));
  const title = `${scene.name} · ${row.technique}, ${row.settings} · ${row.backend}`;
  const pictures = page.rows[index];
  // Maps are square or wider: beside pictures of the screen, three quarters of a column are as tall.
  const map = pictures && pictures.lookups != null && pictures.color == null;
  const shots = !pictures ? null : el("div", { class: map ? "shots map" : "shots" }, shot(pictures.mask, "mask", title), shot(page.truth, "truth", scene.name), shot(pictures.error, "error", title), ...(pictures.color == null ? [] : [shot(pictures.color, "colours", title)]), ...(pictures.lookups == null ? [] : [shot(pictures.lookups, "the map's lookups", `${title} · dark: never looked up; blue to white: by how many pixels`)]));
  return el("article", { class: "panel row", id }, head, shots, figures(m));
}

function select(label, options, onchange) {
  return el("label", {}, `${label} `, el("select", { onchange: (e) => onchange(e.target.value) }, ...options.map((o) => el("option", {}, o))));
}

function rowList(scene, page) {
  const best = page.charts.time || page.charts.cost;
  const front = new Set(best ? best.front : []);
  const state = { all: false, backend: "all", technique: "all", sort: "error" };
  const list = el("div", { class: "rows" });
  const cost = { error: (m) => (m.errors ? m.errors.rmse : Infinity), time: (m) => (m.times ? m.times.total.median : m.cost_ms), cost: (m) => m.cost_ms, acne: (m) => (m.errors ? m.errors.acne : Infinity), memory: (m) => m.bytes };
  const more = el("button", { type: "button", onclick: () => { state.all = !state.all; fill(); } });
  const wanted = (i) => {
    const row = scene.rows[i];
    return (state.all || front.has(i)) && (state.backend === "all" || row.backend === state.backend) && (state.technique === "all" || row.technique === state.technique);
  };
  const fill = () => {
    const key = (i) => { const m = measured(scene.rows[i]); return m ? cost[state.sort](m) : Infinity; };
    const shown = scene.rows.map((_, i) => i).filter(wanted).sort((a, b) => key(a) - key(b) || a - b);
    list.replaceChildren(...shown.map((i) => card(scene, page, i, front.has(i))));
    more.textContent = state.all ? "Show the Pareto fronts alone" : `Show all ${scene.rows.length} rows`;
  };
  const change = (key) => (value) => { state[key] = value; fill(); };
  const values = (key) => ["all", ...new Set(scene.rows.map((r) => r[key]))];
  fill();
  const bar = el("div", { class: "bar" }, more, select("backend", values("backend"), change("backend")),
    select("technique", values("technique"), change("technique")), select("sorted by", Object.keys(cost), change("sort")));
  const show = (i) => {
    if (!front.has(i) || !wanted(i)) { Object.assign(state, { all: true, backend: "all", technique: "all" }); fill(); }
    const node = byId(`row-${page.index}-${i}`);
    list.querySelectorAll(".lit").forEach((n) => n.classList.remove("lit"));
    node.classList.add("lit");
    node.scrollIntoView({ block: "center" });
  };
  return { node: el("div", {}, bar, list), show };
}

function legend() {
  const item = (color, text) => el("span", {}, el("i", { style: `background: ${color}` }), text);
  return el("div", { class: "legend" }, ...data.legend.map(([color, text]) => item(color, text)));
}

function sceneFacts(scene) {
  const t = scene.truth;
  const samples = t.largest_error > 0 ? `${plural(t.samples, "ray")} a receiver, standard error ${number(t.mean_error, 5)} (at most ${number(t.largest_error, 4)})` : "one ray a receiver";
  return [`${scene.light} light`, `${scene.size[0]} × ${scene.size[1]} pixels`, plural(scene.triangles, "triangle"), `truth: ${samples}${t.seconds === null ? "" : `, ${t.seconds.toFixed(1)} s`}`,
    `${t.counted.toLocaleString("en")} pixels count; left out: ${t.ambiguous.toLocaleString("en")} ambiguous, ${t.unlit.toLocaleString("en")} facing away`];
}

function fillScene(section, scene, page) {
  const chart = el("div", { class: "panel chart" });
  const rows = rowList(scene, page);
  const truth = el("div", { class: "panel truth" }, shot(page.truth, "truth", scene.name), legend());
  section.append(el("div", { class: "stage" }, chart, truth), rows.node);
  const mask = (i) => (page.rows[i] ? page.rows[i].mask : null);
  chartOf(chart, page.charts, rows.show, mask);
}

function sceneSection(scene, page) {
  const section = el("section", { class: "scene", id: `scene-${page.index}` }, el("h2", {}, scene.name), el("p", { class: "lead" }, scene.summary),
    el("p", { class: "facts" }, ...sceneFacts(scene).map((f) => el("span", {}, f))),
    scene.nothing_compared ? el("p", { class: "notice" }, scene.nothing_compared) : null);
  section.style.minHeight = "620px";
  // Charts and pictures are made when they come near the window: a report may have thousands.
  const observer = new IntersectionObserver((entries) => {
    if (!entries.some((e) => e.isIntersecting)) return;
    observer.disconnect();
    section.style.minHeight = "";
    fillScene(section, scene, page);
  }, { rootMargin: "900px" });
  observer.observe(section);
  return section;
}

header();
if (comparison.scenes.length) {
  byId("overview").before(el("section", { class: "overview", id: "chart" }, comparison.scenes.length > 1 ? overallChart() : clockSwitch()));
  const overview = () => byId("overview").replaceChildren(tiles(), ...(comparison.scenes.length > 1 ? [matrix()] : []));
  overview();
  dark.addEventListener("change", overview);
  byId("scenes").append(...comparison.scenes.map((scene, i) => sceneSection(scene, pages[i])));
} else {
  byId("overview").append(el("p", { class: "notice" }, "No scene was compared."));
}
