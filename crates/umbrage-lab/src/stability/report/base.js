"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const { stability, pictures } = data;

const number = (v) => (v === 0 ? "0" : Math.abs(v) < 1e-3 ? v.toExponential(1) : v.toPrecision(3));
const withUnit = (v, unit) => `${number(v)}${unit ? ` ${unit}` : ""}`;
const plural = (n, word) => `${n} ${word}${n === 1 ? "" : "s"}`;
const signs = { pass: "✓", not_measured: "·", degraded: "~", fails: "✗", none: "–", fault: "!" };
const key = (cell) => `${cell.technique} (${cell.settings})`;

// The fit is the line's, not the column's.
for (const result of stability.cases) {
  if (result.fit) for (const cell of result.cells) cell.settings = cell.settings.replace(`, ${result.fit}`, "");
}

// Columns: every setting of any case, each once, techniques together; settings of single cases come last.
const columns = [];
for (const cell of stability.cases.flatMap((c) => c.cells)) if (!columns.some((c) => key(c) === key(cell))) columns.push(cell);
const techniques = [...new Set(columns.map((c) => c.technique))];
const isExtra = (column) => !data.verdicts.some((v) => key(v) === key(column));
columns.sort((a, b) => isExtra(a) - isExtra(b) || techniques.indexOf(a.technique) - techniques.indexOf(b.technique));
// All maps have one side, which the page says once.
const shortSettings = (settings) => settings.split(", ").filter((word) => word !== String(stability.map_size)).join(", ").replace("bias: ", "");

function state(cell) {
  if (cell.outcome.measured) return cell.outcome.measured.verdict;
  return cell.outcome.fault ? "fault" : "none";
}

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
  const { left, bottom, top } = event.target.getBoundingClientRect();
  const below = bottom + 6 + box.offsetHeight < innerHeight;
  box.style.left = `${Math.max(4, Math.min(left, innerWidth - box.offsetWidth - 12))}px`;
  box.style.top = `${below ? bottom + 6 : Math.max(4, top - box.offsetHeight - 6)}px`;
}
