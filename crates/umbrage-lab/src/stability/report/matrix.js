"use strict";
// The matrix with its filter, and the details of a cell.

// Current filter: a technique, a row's number, a motion, a verdict ("all": any), and words that a row must contain.
const wanted = { technique: "all", row: "all", motion: "all", verdict: "all", text: "" };
const MOTIONS = { still: (motion) => motion === "still", moving: (motion) => motion !== "still" };
const telling = [...stability.cases.entries()].filter(([, result]) => !result.is_sanity);

const isShownColumn = (column) => wanted.technique === "all" || column.technique === wanted.technique;
const isWantedCell = (cell) => wanted.verdict === "all" || state(cell) === wanted.verdict;
const wordsOf = (result) => [result.row, result.title, result.case, result.weakness, result.motion, ...result.criteria.map((c) => c.measure)].join(" ");

function isShownCase(result) {
  return (wanted.row === "all" || String(result.row) === wanted.row)
    && (wanted.motion === "all" || MOTIONS[wanted.motion](result.motion))
    && hasWords(wordsOf(result), wanted.text)
    && result.cells.some((cell) => isShownColumn(cell) && isWantedCell(cell));
}

function detail(result, cell, picture, button) {
  document.querySelectorAll(".chosen").forEach((b) => b.classList.remove("chosen"));
  if (button) button.classList.add("chosen");
  const moving = result.motion !== "still";
  const caption = moving
    ? "The first frames' masks at fixed points, then their changes in orange."
    : "Truth, mask, error: blue is false shadow, orange is false light.";
  const agreement = cell.disagreeing === null ? null
    : paragraph("soft", cell.disagreeing ? `Backends differ on ${cell.disagreeing} decided pixels.` : "Backends agree.");
  const image = picture && el("a", { href: picture }, el("img", { src: picture, alt: `${result.case}: ${key(cell)}` }));
  const ideal = result.criteria.map((c) => `${c.measure} ${withUnit(c.ideal, c.unit)}`).join(", ");
  const parts = [
    el("h3", {}, `${result.row} ${result.title}: ${result.case}, ${cell.technique}`),
    el("p", {}, el("i", { class: `cell ${state(cell)}` }, signs[state(cell)]), ` ${says(result, cell)}`),
    image, image ? paragraph("soft", caption) : paragraph("soft", "No image: the cell passes, is not measured, or has no mask."),
    paragraph("soft", `Settings: ${cell.settings}${result.fit ? `, ${result.fit}` : ""}. Scene: ${result.scene}, ${result.motion}. A perfect map of ${stability.map_size} texels shows ${ideal}.`),
    paragraph("soft", `Failure: ${result.weakness}. Limits: ${result.criteria.map((c) => `${c.measure}: ${c.reason}`).join(". ")}.`),
    agreement,
  ];
  const box = byId("detail");
  box.hidden = false;
  box.replaceChildren(...parts.filter((part) => part));
}

function cellOf(result, k, column) {
  const i = result.cells.findIndex((c) => key(c) === key(column));
  if (i < 0) return el("td", {});
  const cell = result.cells[i];
  const text = `${key(cell)}. ${says(result, cell)}`;
  const button = el("button", {
    type: "button", class: `cell ${state(cell)}${isWantedCell(cell) ? "" : " faded"}`, "aria-label": text,
    onmouseenter: (e) => tip([text], e), onmouseleave: (e) => tip(null, e), onfocus: (e) => tip([text], e), onblur: (e) => tip(null, e),
    onclick: () => { detail(result, cell, pictures[k][i], button); byId("detail").scrollIntoView({ behavior: "smooth", block: "nearest" }); },
  }, signs[state(cell)]);
  return el("td", {}, button);
}

function headOf(shown) {
  const isFirst = (c, i) => i === 0 || shown[i - 1].technique !== c.technique;
  const head = (c, i) => el("th", { title: key(c), class: isFirst(c, i) ? "first" : null }, el("div", {}, el("b", {}, c.technique), el("br"), shortSettings(c.settings)));
  return el("tr", {}, el("th", { class: "case" }, "row, case"), el("th", { class: "measure" }, "passes up to"), shown.map(head));
}

function lineOf([k, result], isFirst, shown) {
  const yet = result.not_yet ? ` · ${result.not_yet}: not implemented yet` : "";
  const limits = result.criteria.map((c) => `${c.measure} ≤ ${withUnit(c.limits.pass, c.unit)}`).join(", ");
  return el("tr", { class: isFirst ? "first" : null, id: isFirst ? `row-${result.row}` : null },
    el("th", { class: "case", title: `${result.title}: ${result.weakness}${yet}. ${limits}` },
      el("span", { class: "number" }, isFirst ? String(result.row) : ""), el("span", {}, result.case), isFirst ? el("small", {}, result.title) : null),
    el("td", { class: "measure" }, limits),
    shown.map((c) => cellOf(result, k, c)));
}

function drawMatrix() {
  const shown = columns.filter(isShownColumn);
  const cases = telling.filter(([, result]) => isShownCase(result));
  const lines = cases.map((entry, i) => lineOf(entry, i === 0 || cases[i - 1][1].row !== entry[1].row, shown));
  byId("matrix").replaceChildren(el("thead", {}, headOf(shown)), el("tbody", {}, lines));
  byId("told").textContent = `${cases.length} of ${plural(telling.length, "case")}`;
  for (const control of document.querySelectorAll("#filter [name]")) control.value = wanted[control.name];
}

function filterBar() {
  const rows = new Map(telling.map(([, result]) => [String(result.row), `${result.row} ${result.title}`]));
  const verdicts = [["all", "any"], ["fails", "fails"], ["degraded", "degraded"], ["not_measured", "not measured"], ["pass", "passes"], ["none", "unsupported"]];
  const filters = controls(wanted, drawMatrix, [
    ["find", "text", { type: "search", placeholder: "row, case, weakness, measure", size: 26 }], ["technique", "technique", ["all", ...techniques]],
    ["row", "row", ["all", ...rows]], ["motion", "motion", [["all", "any"], "still", "moving"]], ["verdict", "verdict", verdicts]]);
  byId("filter").append(...filters, el("button", { type: "button", onclick: () => show({}) }, "all"), el("span", { id: "told" }));
}

// Sets the filter to these values alone, and redraws the matrix.
function show(only) {
  Object.assign(wanted, { technique: "all", row: "all", motion: "all", verdict: "all", text: "" }, only);
  drawMatrix();
}

// Applies a filter at the end of the address: `#technique=pcf&verdict=fails`.
function fromAddress() {
  const given = [...new URLSearchParams(location.hash.slice(1))].filter(([name]) => name in wanted);
  if (!given.length) return;
  show(Object.fromEntries(given));
  byId("all").scrollIntoView();
}
