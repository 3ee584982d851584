"use strict";
const { stability, pictures } = data;

const number = (v) => (v === 0 ? "0" : Math.abs(v) < 1e-3 ? v.toExponential(1) : v.toPrecision(3));
const withUnit = (v, unit) => `${number(v)}${unit ? ` ${unit}` : ""}`;
const signs = { pass: "✓", not_measured: "·", degraded: "~", fails: "✗", none: "–", fault: "!" };
const key = (cell) => `${cell.technique} (${cell.settings})`;

// The fit is printed once per line, not in each column.
for (const result of stability.cases) {
  if (result.fit) for (const cell of result.cells) cell.settings = cell.settings.replace(`, ${result.fit}`, "");
}

// Columns: each setting of any case once, grouped by technique; settings of single cases come last.
const columns = [...new Map(stability.cases.flatMap((c) => c.cells).map((cell) => [key(cell), cell])).values()];
const techniques = [...new Set(columns.map((c) => c.technique))];
const isExtra = (column) => !data.verdicts.some((v) => key(v) === key(column));
columns.sort((a, b) => isExtra(a) - isExtra(b) || techniques.indexOf(a.technique) - techniques.indexOf(b.technique));
// All maps have the same side, which the page states once.
const shortSettings = (settings) => settings.split(", ").filter((word) => word !== String(stability.map_size)).join(", ").replace("bias: ", "");

function state(cell) {
  if (cell.outcome.measured) return cell.outcome.measured.verdict;
  return cell.outcome.fault ? "fault" : "none";
}

function says(result, cell) {
  const o = cell.outcome;
  if (o.fault) return o.fault.what;
  if (o.unsupported) return `unsupported: ${o.unsupported.reason}`;
  return o.measured.judgements.map((judgement, k) => judged(result.criteria[k], judgement)).join("; ");
}

function judged({ measure, unit, limits }, { figure, verdict, reason }) {
  if (figure === null) return `${measure}: not measured: ${reason}`;
  return `${measure}: ${withUnit(figure, unit)} ${signs[verdict]} (passes up to ${withUnit(limits.pass, unit)}, fails above ${withUnit(limits.fails, unit)})`;
}
