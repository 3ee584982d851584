"use strict";
// What `stability` says of a setting: how many rows it fails, and which.

const stability = data.stability;
// Titles of failed rows that are named where there is little room.
const NAMED_ROWS = 3;

// A row's verdicts; null without any.
function verdictOf(row) {
  const verdict = stability === null || row.verdict === null ? null : stability.verdicts[row.verdict];
  return verdict && verdict.measured > 0 ? verdict : null;
}

// All of it, for the pointer.
function verdictTitle(v, isOwn) {
  const cases = v.failed.map((f) => `${f.title} (${f.cases.join(", ")}${f.cured_by ? `; not with the ${f.cured_by}` : ""})`);
  return [
    `${v.technique}, ${v.settings}${isOwn ? "" : ": the same bias, another kernel"}`, `fails: ${cases.join(", ") || "nothing"}`,
    `degraded: ${v.degraded.map((f) => f.title).join(", ") || "nothing"}`,
    `passes ${v.passed} of ${plural(v.measured, "row")}; ${v.not_measured} not measured, not made for ${v.not_served}`,
  ].join("\n");
}

// A link to cells of the technique, or plain words without a page to link to.
function verdictLink(row, words, kind, filter) {
  const v = verdictOf(row);
  const title = verdictTitle(v, row.is_own_verdict);
  if (stability.href === null) return el("span", { class: kind, title }, words);
  const address = new URLSearchParams({ technique: v.technique, ...filter });
  return el("a", { class: kind, title, href: `${encodeURI(stability.href)}#${address}`, onclick: (e) => e.stopPropagation() }, words);
}

// In how many rows a setting fails, and at most `most` of them by name.
function verdictWords(row, most) {
  const v = verdictOf(row);
  if (!v) return null;
  const titles = v.failed.slice(0, most).map((failed) => failed.title).join(", ");
  const words = [`fails ${v.failed.length || "none"} of ${plural(v.measured, "row")}`, titles && `: ${titles}`, titles && v.failed.length > most ? ", .." : "", row.is_own_verdict ? "" : " (played with another kernel)"];
  return verdictLink(row, words.join(""), v.failed.length ? "verdict" : "verdict good", { verdict: v.failed.length ? "fails" : "all" });
}

// Where verdicts come from, or how to get them.
function verdictSource() {
  if (stability === null) {
    return paragraph("quiet wide", "Where these techniques fail is not known here: run `stability`, and give its folder to `compare` (or `merge`) with --stability.");
  }
  const page = stability.href === null ? [] : [" (", el("a", { href: encodeURI(stability.href) }, "the stability page"), ")"];
  return el("div", {},
    paragraph("quiet wide", "\u201cFails\u201d counts rows of the catalogue of failures", page, `, each with the worst of its cases: ${stability.told}.`),
    stability.stale === null ? null : paragraph("notice", `These verdicts may be stale: ${stability.stale}. Run \`stability\` again.`));
}
