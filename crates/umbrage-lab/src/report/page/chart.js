"use strict";
// Charts of error against time, both axes logarithmic.

// Outlines about the origin, one unit in radius.
const polygon = (corners, turn) => {
  const at = (i) => `${Math.sin((2 * Math.PI * (i + turn)) / corners).toFixed(3)},${(-Math.cos((2 * Math.PI * (i + turn)) / corners)).toFixed(3)}`;
  return `M${Array.from({ length: corners }, (_, i) => at(i)).join("L")}Z`;
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

function marker(technique, x, y, radius, fill) {
  const name = data.styles[technique].marker;
  const turn = name === "Cross" ? " rotate(45)" : "";
  return svgEl("path", { d: SHAPES[name], fill, transform: `translate(${x} ${y}) scale(${radius})${turn}` });
}

// How far from a point the pointer finds it, in units of the drawing.
const REACH = 24;
const MARGIN = { left: 58, right: 16, top: 12, bottom: 44 };
const LETTER = 6.1;
// Charts in narrower places are scaled down.
const MIN_WIDTH = 540;

// Ticks at 1, 2 and 5, or at each decade where there are many.
function ticksBetween(least, greatest) {
  const digits = Math.log10(greatest / least) < 2.2 ? [1, 2, 5] : [1];
  const out = [];
  for (let decade = Math.floor(Math.log10(least)); decade <= Math.log10(greatest); decade += 1) {
    out.push(...digits.map((digit) => digit * 10 ** decade));
  }
  return out.filter((v) => v >= least * 0.999 && v <= greatest * 1.001);
}
const tickText = (v) => (v >= 1e5 || v < 1e-4 ? v.toExponential(0) : String(Number(v.toPrecision(1))));

// The part of an axis that holds all values, with a little room at both ends.
function domain(values, room) {
  const least = Math.min(...values);
  const greatest = Math.max(...values);
  const wide = Math.max(greatest / least, 2) ** room;
  return [least / wide, greatest * wide];
}
const scale = ([least, greatest], from, to) => (v) => from + (Math.log(v / least) / Math.log(greatest / least)) * (to - from);

// Places of the points, and both axes. Exact points lie on a line of their own below the others.
function layoutOf(points, spec) {
  const isExact = (p) => p.y < spec.exact;
  const inexact = points.filter((p) => !isExact(p)).map((p) => p.y);
  const lowest = inexact.length ? Math.min(...inexact) : spec.exact * 10;
  const hasExact = points.some(isExact);
  const floor = Math.max(lowest / 2.2, spec.exact * 0.5);
  const ys = [lowest, ...inexact, ...(hasExact ? [floor] : [])];
  const across = domain(points.map((p) => p.x), 0.06);
  const up = domain([...ys, ...(spec.reference ? [spec.reference] : [])], 0.05);
  const x = scale(across, MARGIN.left, spec.width - MARGIN.right);
  const y = scale(up, spec.height - MARGIN.bottom, MARGIN.top);
  points.forEach((p) => Object.assign(p, { px: x(p.x), py: y(isExact(p) ? floor : p.y) }));
  const upTicks = ticksBetween(hasExact ? lowest * 0.8 : up[0], up[1]);
  return { x, y, acrossTicks: ticksBetween(...across), upTicks, exactAt: hasExact ? y(floor) : null };
}

function axes(svg, layout, spec) {
  const bottom = spec.height - MARGIN.bottom;
  const right = spec.width - MARGIN.right;
  const line = (x1, y1, x2, y2, kind) => svg.append(svgEl("line", { x1, y1, x2, y2, class: kind }));
  const text = (x, y, words, anchor, extra) => svg.append(svgEl("text", { x, y, "text-anchor": anchor, ...extra }, words));
  for (const v of layout.acrossTicks) {
    line(layout.x(v), MARGIN.top, layout.x(v), bottom, "grid");
    text(layout.x(v), bottom + 16, tickText(v), "middle");
  }
  for (const v of layout.upTicks) {
    line(MARGIN.left, layout.y(v), right, layout.y(v), "grid");
    text(MARGIN.left - 7, layout.y(v) + 4, tickText(v), "end");
  }
  if (layout.exactAt !== null) {
    line(MARGIN.left, layout.exactAt, right, layout.exactAt, "exact");
    text(MARGIN.left - 7, layout.exactAt + 4, "exact", "end", { class: "strong" });
  }
  if (spec.reference) {
    line(MARGIN.left, layout.y(spec.reference), right, layout.y(spec.reference), "reference");
    text(right - 4, layout.y(spec.reference) + 14, "no shadow", "end");
  }
  line(MARGIN.left, bottom, right, bottom, "axis");
  line(MARGIN.left, MARGIN.top, MARGIN.left, bottom, "axis");
  text((MARGIN.left + right) / 2, spec.height - 8, spec.xWords, "middle");
  const middle = (MARGIN.top + bottom) / 2;
  text(14, middle, spec.yWords, "middle", { transform: `rotate(-90 14 ${middle})` });
}

function frontLines(svg, points) {
  for (const backend of data.backends) {
    const front = points.filter((p) => p.front && p.backend === backend).sort((a, b) => a.px - b.px);
    const path = front.map((p) => `${p.px.toFixed(1)},${p.py.toFixed(1)}`).join(" ");
    if (front.length > 1) svg.append(svgEl("polyline", { points: path, class: "front", stroke: colorOf(front[0].technique, backend) }));
  }
}

function drawPoint(svg, p) {
  const color = colorOf(p.technique, p.backend);
  p.group = svgEl("g", { class: p.front ? "point" : "point faint" });
  p.group.append(marker(p.technique, p.px, p.py, p.front ? 6.5 : 4.5, color));
  svg.append(p.group);
}

const overlap = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
// Places around a point where its label may begin, the best ones first.
function labelPlaces(p, width) {
  const out = [];
  for (const away of [9, 20, 34, 50]) {
    out.push([p.px + away - 1, p.py - 8 - away * 0.8], [p.px + away, p.py - 6], [p.px - width / 2, p.py - 12 - away], [p.px - away - width, p.py - 6]);
    out.push([p.px + away, p.py + 2 + (away - 9)], [p.px - width / 2, p.py + away], [p.px - away - width, p.py + (away - 9)]);
  }
  return out.map(([x, y]) => ({ x, y, width, height: 13 }));
}

// Labels beside the points that are named, those of fronts above all, where they cover neither each other nor a front's points. What finds no place is left to the pointer.
function labels(svg, points, spec) {
  const named = points.filter((p) => p.front || p.named);
  const taken = named.map((p) => ({ x: p.px - 7, y: p.py - 7, width: 14, height: 14 }));
  const isInside = (box) => box.x > MARGIN.left + 2 && box.x + box.width < spec.width - MARGIN.right && box.y > 2 && box.y + box.height < spec.height - MARGIN.bottom;
  for (const p of named.sort((a, b) => b.front - a.front)) {
    const places = labelPlaces(p, p.label.length * LETTER + 4);
    const box = places.find((place) => isInside(place) && !taken.some((other) => overlap(place, other)));
    if (!box) continue;
    taken.push(box);
    svg.append(svgEl("text", { x: box.x + 2, y: box.y + 10.5, class: "label" }, p.label));
  }
}

// The shapes below a chart: a click hides and shows a technique, a double click shows it alone.
function legendOf(points, muted, update) {
  const names = [...new Set(points.map((p) => p.technique))];
  const box = el("div", { class: "shapes" });
  for (const name of names) {
    const icon = svgEl("svg", { viewBox: "-8 -8 16 16", width: 14, height: 14 });
    icon.append(marker(name, 0, 0, 6, colorOf(name, points[0].backend)));
    const button = el("button", { type: "button" }, icon, name);
    const show = () => button.setAttribute("aria-pressed", !muted.has(name));
    button.addEventListener("click", () => { if (!muted.delete(name)) muted.add(name); update(); });
    button.addEventListener("dblclick", () => { names.forEach((n) => muted.add(n)); muted.delete(name); update(); });
    button.show = show;
    box.append(button);
  }
  const backends = data.backends.filter((backend) => points.some((p) => p.backend === backend));
  if (backends.length > 1) box.append(...backends.map((backend) => el("span", { class: "backend", style: `color: ${colorOf(names[0], backend)}` }, backend)));
  box.show = () => box.querySelectorAll("button").forEach((b) => b.show());
  return box;
}

// A chart of what `spec.points()` gives, drawn anew when the clock or its width changes. Under the pointer a point tells what it is and shows its
// picture; a click leads to its row.
function chartOf(node, spec) {
  const muted = new Set();
  let drawnAt = 0;
  const draw = () => {
    drawnAt = node.clientWidth;
    if (!drawnAt) return;
    // As wide as its place, so that letters keep their size.
    const drawn = { ...spec, width: Math.max(MIN_WIDTH, drawnAt - 24), xWords: spec.xWords() };
    const points = spec.points().filter((p) => p.x > 0 && p.y !== null);
    if (!points.length) return node.replaceChildren(el("p", { class: "quiet" }, "Nothing to draw."));
    const svg = svgEl("svg", { viewBox: `0 0 ${drawn.width} ${drawn.height}`, role: "img", "aria-label": spec.yWords });
    axes(svg, layoutOf(points, drawn), drawn);
    frontLines(svg, points);
    [...points].sort((a, b) => a.front - b.front).forEach((p) => drawPoint(svg, p));
    labels(svg, points, drawn);
    const update = () => {
      points.forEach((p) => p.group.classList.toggle("muted", muted.has(p.technique)));
      legend.show();
    };
    const legend = legendOf(points, muted, update);
    pointer(svg, points, muted, spec);
    node.replaceChildren(svg, legend);
    update();
  };
  new ResizeObserver(() => { if (node.clientWidth !== drawnAt) draw(); }).observe(node);
  clockListeners.push(draw);
  return draw;
}

function pointer(svg, points, muted, spec) {
  const nearest = (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const distance = (p) => Math.hypot(p.px - at.x, p.py - at.y);
    const near = points.filter((p) => !muted.has(p.technique) && distance(p) < REACH);
    // Of two points in one place the one on a front is drawn above the other.
    return near.reduce((best, p) => (best && distance(best) - (best.front ? 3 : 0) < distance(p) ? best : p), null);
  };
  let lit = null;
  const light = (point, event) => {
    if (lit) lit.group.classList.remove("lit");
    lit = point;
    if (lit) lit.group.classList.add("lit");
    svg.classList.toggle("near", lit !== null);
    tip(lit && lit.lines(), event);
    peek(lit && lit.row, event);
  };
  svg.addEventListener("pointermove", (e) => light(nearest(e), e));
  svg.addEventListener("pointerleave", (e) => light(null, e));
  svg.addEventListener("click", (e) => {
    const point = nearest(e);
    if (!point || !point.row) return;
    light(null, e);
    spec.onclick(point.row);
  });
}

// The technique with its first two settings.
const labelOf = (technique, settings) => `${technique} ${settings.split(", ").slice(0, 2).join(", ")}`.trim();
