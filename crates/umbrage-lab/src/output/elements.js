"use strict";
// The first script of every page: elements, tables, controls and the text at the pointer. All that is shown is built from text nodes, never from
// strings of markup, so no name can smuggle in any.
const byId = (id) => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const plural = (n, word) => `${n.toLocaleString("en")} ${word}${n === 1 ? "" : "s"}`;

function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children.flat().filter((c) => c !== null && c !== undefined));
  return node;
}
const paragraph = (kind, ...children) => el("p", { class: kind }, ...children);
const table = (kind, head, lines) => el("div", { class: "scroll" }, el("table", { class: kind }, el("thead", {}, el("tr", {}, head)), el("tbody", {}, lines)));

// Controls that set entries of `state` and then call `changed`: lists of choices (texts, or pairs of value and text) and fields.
function controls(state, changed, all) {
  return all.map(([label, name, kind]) => {
    const oninput = (e) => { state[name] = e.target.value; changed(); };
    const option = (choice) => el("option", { value: [choice].flat()[0] }, [choice].flat().at(-1));
    const control = Array.isArray(kind) ? el("select", { name, oninput }, kind.map(option)) : el("input", { name, oninput, ...kind });
    return el("label", {}, `${label} `, control);
  });
}
const hasWords = (text, words) => words.toLowerCase().split(/\s+/).every((word) => text.toLowerCase().includes(word));

// Lines of text beside the pointer, or beside the element that has the focus.
function tip(lines, event) {
  const box = byId("tip");
  box.hidden = !lines;
  if (box.hidden) return;
  box.replaceChildren(...lines.map((line, i) => el(i === 0 ? "b" : "span", {}, line)));
  const gap = 14;
  const { width, height } = box.getBoundingClientRect();
  const target = event.target.getBoundingClientRect();
  const [x, y] = [event.clientX ?? target.left, event.clientY ?? target.bottom];
  const left = x + gap + width < innerWidth ? x + gap : Math.max(4, x - gap - width);
  const top = y + gap + height < innerHeight ? y + gap : Math.max(4, y - gap - height);
  Object.assign(box.style, { left: `${left}px`, top: `${top}px` });
}
