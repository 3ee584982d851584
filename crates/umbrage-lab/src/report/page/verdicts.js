"use strict";
// What `stability` says of a setting: how many rows it fails, and which.

const stability = data.stability;
// Titles of failed rows that are named where there is little room.
const NAMED_ROWS = 3;

const verdictOf = (row) => (stability === null || row.verdict === null ? null : stability.verdicts[row.verdict]);
const isTold = (verdict) => verdict !== null && verdict.measured > 0;
const countWords = (v) => `fails ${v.failed.length ? v.failed.length : "none"} of ${plural(v.measured, "row")}`;

// In how many rows it fails, and a few of them.
function verdictWords(v, most) {
  const titles = v.failed.slice(0, most).map((failed) => failed.title);
  const rest = v.failed.length > most ? ", .." : "";
  return titles.length ? `${countWords(v)}: ${titles.join(", ")}${rest}` : countWords(v);
}

// All of it, for the pointer.
function verdictTitle(v, isOwn) {
  const cases = v.failed.map((f) => `${f.title} (${f.cases.join(", ")}${f.cured_by ? `; not with the ${f.cured_by}` : ""})`);
  const degraded = v.degraded.map((f) => f.title).join(", ");
  const lines = [`${v.technique}, ${v.settings}${isOwn ? "" : ": the same bias, another kernel"}`, `fails: ${cases.join(", ") || "nothing"}`, `degraded: ${degraded || "nothing"}`];
  lines.push(`passes ${v.passed} of ${plural(v.measured, "row")}; ${v.not_measured} not measured, not made for ${v.not_served}`);
  return lines.join("\n");
}

// A link to the technique's cells, or plain words without a page to link to.
function verdictLink(row, most) {
  const v = verdictOf(row);
  if (!isTold(v)) return null;
  const words = verdictWords(v, most) + (row.is_own_verdict ? "" : " (played with another kernel)");
  const title = verdictTitle(v, row.is_own_verdict);
  const kind = v.failed.length ? "verdict" : "verdict good";
  if (stability.href === null) return el("span", { class: kind, title }, words);
  const filter = new URLSearchParams({ technique: v.technique, verdict: v.failed.length ? "fails" : "all" });
  return el("a", { class: kind, title, href: `${encodeURI(stability.href)}#${filter}`, onclick: (e) => e.stopPropagation() }, words);
}

// Where verdicts come from, or how to get them.
function verdictSource() {
  if (stability === null) {
    return el("p", { class: "quiet wide" }, "Where these techniques fail is not known here: run `stability`, and give its folder to `compare` (or `merge`) with --stability.");
  }
  const page = stability.href === null ? null : el("a", { href: encodeURI(stability.href) }, "the stability page");
  return el("div", {},
    el("p", { class: "quiet wide" }, "\u201cFails\u201d counts rows of the catalogue of failures", page ? [" (", page, ")"] : null, `, each with the worst of its cases: ${stability.told}.`),
    stability.stale === null ? null : el("p", { class: "notice" }, `These verdicts may be stale: ${stability.stale}. Run \`stability\` again.`));
}
