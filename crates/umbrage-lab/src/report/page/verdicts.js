"use strict";
// Verdicts of `stability` on a setting: the number of failed rows, and their names.

const stability = data.stability;
// Greatest number of failed rows named in small places.
const NAMED_ROWS = 3;

// Returns a row's verdicts; null without any.
function verdictOf(row) {
  const verdict = stability === null || row.verdict === null ? null : stability.verdicts[row.verdict];
  return verdict && verdict.measured > 0 ? verdict : null;
}

// Returns the full verdicts, for the tooltip.
function verdictTitle(v, isOwn) {
  const cases = v.failed.map((f) => `${f.title} (${f.cases.join(", ")}${f.cured_by ? `; not with the ${f.cured_by}` : ""})`);
  return [
    `${v.technique}, ${v.settings}${isOwn ? "" : ": the same bias, another kernel"}`, `fails: ${cases.join(", ") || "nothing"}`,
    `degraded: ${v.degraded.map((f) => f.title).join(", ") || "nothing"}`,
    `passes ${v.passed} of ${plural(v.measured, "row")}; ${v.not_measured} not measured, ${v.not_served} unsupported`,
  ].join("\n");
}

// Returns a link to cells of the technique, or plain text without a page to link to.
function verdictLink(row, words, kind, filter) {
  const v = verdictOf(row);
  const title = verdictTitle(v, row.is_own_verdict);
  if (stability.href === null) return el("span", { class: kind, title }, words);
  const address = new URLSearchParams({ technique: v.technique, ...filter });
  return el("a", { class: kind, title, href: `${encodeURI(stability.href)}#${address}`, onclick: (e) => e.stopPropagation() }, words);
}

// Returns the number of rows that a setting fails, and at most `most` of them by name.
function verdictWords(row, most) {
  const v = verdictOf(row);
  if (!v) return null;
  const titles = v.failed.slice(0, most).map((failed) => failed.title).join(", ");
  const words = [`fails ${v.failed.length || "none"} of ${plural(v.measured, "row")}`, titles && `: ${titles}`, titles && v.failed.length > most ? ", .." : "", row.is_own_verdict ? "" : " (tested with another kernel)"];
  return verdictLink(row, words.join(""), v.failed.length ? "verdict" : "verdict good", { verdict: v.failed.length ? "fails" : "all" });
}

// Returns the source of the verdicts, or how to get them.
function verdictSource() {
  if (stability === null) {
    return paragraph("quiet wide", "Failures of these techniques are unknown here: run `stability`, and pass its folder to `compare` (or `merge`) with --stability.");
  }
  const page = stability.href === null ? [] : [" (", el("a", { href: encodeURI(stability.href) }, "the stability page"), ")"];
  return el("div", {},
    paragraph("quiet wide", "\u201cFails\u201d counts rows of the failure catalogue", page, `, each with the worst of its cases: ${stability.told}.`),
    stability.stale === null ? null : paragraph("notice", `These verdicts may be stale: ${stability.stale}. Run \`stability\` again.`));
}
