"use strict";
// Charts of error against time, both axes logarithmic.

function svgEl(tag, attributes, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

// Outlines about the origin, one unit in radius.
const polygon = (corners, turn) => {
  const angles = Array.from({ length: corners }, (_, i) => (2 * Math.PI * (i + turn)) / corners);
  return `M${angles.map((a) => `${Math.sin(a).toFixed(3)},${(-Math.cos(a)).toFixed(3)}`).join("L")}Z`;
};
const PLUS = "M-.35-1H.35V-.35H1V.35H.35V1H-.35V.35H-1V-.35H-.35Z";
const SHAPES = {
  Circle: "M-1 0A1 1 0 1 1 1 0A1 1 0 1 1-1 0Z",
  Diamond: polygon(4, 0),
  Square: "M-.85-.85H.85V.85H-.85Z",
  Triangle: polygon(3, 0),
  TriangleDown: polygon(3, 0.5),
  Star: "M0-1.2L.3-.4 1.15-.37 .48.15 .7.97 0 .5-.7.97-.48.15-1.15-.37-.3-.4Z",
  Hexagon: polygon(6, 0.5),
  Pentagon: polygon(5, 0),
  Cross: PLUS,
  Plus: PLUS,
};
const colorOf = (technique, backend) => data.styles[technique].colors[Math.min(2, Math.max(0, data.backends.indexOf(backend)))];

function marker(technique, backend, x, y, radius) {
  const name = data.styles[technique].marker;
  return svgEl("path", { d: SHAPES[name], fill: colorOf(technique, backend), transform: `translate(${x} ${y}) scale(${radius})${name === "Cross" ? " rotate(45)" : ""}` });
}

// Greatest distance at which the pointer finds a point, in units of the drawing.
const REACH = 24;
const MARGIN = { left: 58, right: 16, top: 12, bottom: 44 };
const LETTER = 6.1;
// Charts in narrower containers are scaled down.
const MIN_WIDTH = 540;

// Returns ticks at 1, 2 and 5, or at each decade over wide ranges.
function ticksBetween(least, greatest) {
  const digits = Math.log10(greatest / least) < 2.2 ? [1, 2, 5] : [1];
  const out = [];
  for (let decade = Math.floor(Math.log10(least)); decade <= Math.log10(greatest); decade += 1) out.push(...digits.map((digit) => digit * 10 ** decade));
  return out.filter((v) => v >= least * 0.999 && v <= greatest * 1.001);
}
const tickText = (v) => (v >= 1e5 || v < 1e-4 ? v.toExponential(0) : String(Number(v.toPrecision(1))));

// Returns a logarithmic axis between two positions that contains all values, with a margin at both ends.
function axisOf(values, room, from, to) {
  const least = Math.min(...values);
  const greatest = Math.max(...values);
  const wide = Math.max(greatest / least, 2) ** room;
  const ends = [least / wide, greatest * wide];
  return { ends, at: (v) => from + (Math.log(v / ends[0]) / Math.log(ends[1] / ends[0])) * (to - from) };
}

// Places the points, and returns both axes. Exact points are on their own line below the others.
function layoutOf(points, spec) {
  const isExact = (p) => p.y < spec.exact;
  const inexact = points.filter((p) => !isExact(p)).map((p) => p.y);
  const lowest = inexact.length ? Math.min(...inexact) : spec.exact * 10;
  const hasExact = points.some(isExact);
  const floor = Math.max(lowest / 2.2, spec.exact * 0.5);
  const x = axisOf(points.map((p) => p.x), 0.06, MARGIN.left, spec.right);
  const y = axisOf([lowest, ...inexact, ...(hasExact ? [floor] : []), ...(spec.reference ? [spec.reference] : [])], 0.05, spec.bottom, MARGIN.top);
  points.forEach((p) => Object.assign(p, { px: x.at(p.x), py: y.at(isExact(p) ? floor : p.y) }));
  return { x, y, upTicks: ticksBetween(hasExact ? lowest * 0.8 : y.ends[0], y.ends[1]), exactAt: hasExact ? y.at(floor) : null };
}

function drawAxes(svg, { x, y, upTicks, exactAt }, { right, bottom, reference, xWords, yWords, height }) {
  const line = (x1, y1, x2, y2, kind) => svg.append(svgEl("line", { x1, y1, x2, y2, class: kind }));
  const across = (at, kind) => line(MARGIN.left, at, right, at, kind);
  const write = (px, py, words, anchor, extra) => svg.append(svgEl("text", { x: px, y: py, "text-anchor": anchor, ...extra }, words));
  for (const v of ticksBetween(...x.ends)) {
    line(x.at(v), MARGIN.top, x.at(v), bottom, "grid");
    write(x.at(v), bottom + 16, tickText(v), "middle");
  }
  for (const v of upTicks) {
    across(y.at(v), "grid");
    write(MARGIN.left - 7, y.at(v) + 4, tickText(v), "end");
  }
  if (exactAt !== null) {
    across(exactAt, "exact");
    write(MARGIN.left - 7, exactAt + 4, "exact", "end", { class: "strong" });
  }
  if (reference) {
    across(y.at(reference), "reference");
    write(right - 4, y.at(reference) + 14, "no shadow", "end");
  }
  across(bottom, "axis");
  line(MARGIN.left, MARGIN.top, MARGIN.left, bottom, "axis");
  write((MARGIN.left + right) / 2, height - 8, xWords, "middle");
  const middle = (MARGIN.top + bottom) / 2;
  write(14, middle, yWords, "middle", { transform: `rotate(-90 14 ${middle})` });
}

function drawPoints(svg, points) {
  for (const backend of data.backends) {
    const front = points.filter((p) => p.front && p.backend === backend).sort((a, b) => a.px - b.px);
    const path = front.map((p) => `${p.px.toFixed(1)},${p.py.toFixed(1)}`).join(" ");
    if (front.length > 1) svg.append(svgEl("polyline", { points: path, class: "front", stroke: colorOf(front[0].technique, backend) }));
  }
  for (const p of [...points].sort((a, b) => a.front - b.front)) {
    p.group = svgEl("g", { class: p.front ? "point" : "point faint" }, marker(p.technique, p.backend, p.px, p.py, p.front ? 6.5 : 4.5));
    svg.append(p.group);
  }
}

// Labels the named points, those of fronts first, where labels cover neither each other nor a front's points. Labels without a free position are only
// in tooltips.
function drawLabels(svg, points, spec) {
  const isNamed = points.filter((p) => p.front || p.named);
  const taken = isNamed.map((p) => ({ x: p.px - 7, y: p.py - 7, width: 14, height: 14 }));
  const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
  const isFree = (box) => box.x > MARGIN.left + 2 && box.x + box.width < spec.right && box.y > 2 && box.y + box.height < spec.bottom && !taken.some((other) => overlap(box, other));
  for (const p of isNamed.sort((a, b) => b.front - a.front)) {
    const label = `${p.technique} ${firstSettings(p.settings)}`.trim();
    const width = label.length * LETTER + 4;
    // Candidate positions of the label around the point, the best ones first.
    const places = [9, 20, 34, 50].flatMap((away) => [
      [away - 1, -8 - away * 0.8], [away, -6], [-width / 2, -12 - away], [-away - width, -6], [away, 2 + (away - 9)], [-width / 2, away], [-away - width, away - 9],
    ]);
    const box = places.map(([x, y]) => ({ x: p.px + x, y: p.py + y, width, height: 13 })).find(isFree);
    if (!box) continue;
    taken.push(box);
    svg.append(svgEl("text", { x: box.x + 2, y: box.y + 10.5, class: "label" }, label));
  }
}

// Returns the legend below a chart: a click hides or shows a technique, a double click shows only it.
function legendOf(points, muted, update) {
  const names = [...new Set(points.map((p) => p.technique))];
  const entry = (name) => {
    const icon = svgEl("svg", { viewBox: "-8 -8 16 16", width: 14, height: 14 }, marker(name, points[0].backend, 0, 0, 6));
    const toggle = () => { if (!muted.delete(name)) muted.add(name); update(); };
    const alone = () => { names.forEach((n) => muted.add(n)); muted.delete(name); update(); };
    return button({ "data-technique": name, onclick: toggle, ondblclick: alone }, icon, name);
  };
  const backends = data.backends.filter((backend) => points.some((p) => p.backend === backend));
  const words = backends.map((backend) => el("span", { class: "backend", style: `color: ${colorOf(names[0], backend)}` }, backend));
  return el("div", { class: "shapes" }, names.map(entry), backends.length > 1 ? words : []);
}

// Draws a chart of `spec.points()`, and redraws it when the clock or its width changes. The point under the pointer shows a tooltip and its image; a
// click leads to its row.
function chartOf(node, spec) {
  const muted = new Set();
  let drawnAt = 0;
  const draw = () => {
    drawnAt = node.clientWidth;
    if (!drawnAt) return;
    // Use the container's width, so that letters keep their size.
    const width = Math.max(MIN_WIDTH, drawnAt - 24);
    const drawn = { ...spec, right: width - MARGIN.right, bottom: spec.height - MARGIN.bottom, xWords: spec.xWords() };
    const points = spec.points().filter((p) => p.x > 0 && p.y !== null);
    if (!points.length) return node.replaceChildren(paragraph("quiet", "Nothing to draw."));
    const svg = svgEl("svg", { viewBox: `0 0 ${width} ${spec.height}`, role: "img", "aria-label": spec.yWords });
    drawAxes(svg, layoutOf(points, drawn), drawn);
    drawPoints(svg, points);
    drawLabels(svg, points, drawn);
    const update = () => {
      points.forEach((p) => p.group.classList.toggle("muted", muted.has(p.technique)));
      legend.querySelectorAll("button").forEach((b) => b.setAttribute("aria-pressed", !muted.has(b.dataset.technique)));
    };
    const legend = legendOf(points, muted, update);
    addPointer(svg, points, muted, spec.onclick);
    node.replaceChildren(svg, legend);
    update();
  };
  new ResizeObserver(() => { if (node.clientWidth !== drawnAt) draw(); }).observe(node);
  clockListeners.push(draw);
  return draw;
}

function addPointer(svg, points, muted, onclick) {
  const nearest = (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const distance = (p) => Math.hypot(p.px - at.x, p.py - at.y);
    const near = points.filter((p) => !muted.has(p.technique) && distance(p) < REACH);
    // Of two points in one position, prefer the one on a front, which is drawn on top.
    return near.reduce((best, p) => (best && distance(best) - (best.front ? 3 : 0) < distance(p) ? best : p), null);
  };
  const light = (point, event) => {
    points.forEach((p) => p.group.classList.toggle("lit", p === point));
    svg.classList.toggle("near", point !== null);
    tip(point && point.lines(), event);
    peek(point && point.row, event);
  };
  svg.addEventListener("pointermove", (e) => light(nearest(e), e));
  svg.addEventListener("pointerleave", (e) => light(null, e));
  svg.addEventListener("click", (e) => {
    const point = nearest(e);
    if (!point || !point.row) return;
    light(null, e);
    onclick(point.row);
  });
}
