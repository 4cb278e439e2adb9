// Elements of the page. Texts go in as text, never as markup: names come from files of others.

export const byId = (id) => document.getElementById(id);

// make("label", {htmlFor: "a"}, "Time", input)
export function make(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

export function choices(select, names) {
  select.replaceChildren(...names.map(([value, text]) => make("option", { value }, text)));
}

export function fillTable(table, head, rows) {
  const line = (cells, tag) => make("tr", {}, ...cells.map((cell, k) => make(k ? tag : "th", { scope: k && tag === "td" ? "" : tag === "th" ? "col" : "row" }, cell)));
  table.replaceChildren(make("thead", {}, line(head, "th")), make("tbody", {}, ...rows.map((row) => line(row, "td"))));
}

export function save(name, content, type) {
  const link = make("a", { href: URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// Three digits that mean something.
export function digits(value) {
  if (!Number.isFinite(value)) return "–";
  const text = Number(value.toPrecision(3));
  return Math.abs(text) >= 1e5 || (text !== 0 && Math.abs(text) < 1e-3) ? text.toExponential(2) : String(text);
}
