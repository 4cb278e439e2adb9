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
  const top = head.map((cell) => (cell ? make("th", { scope: "col" }, cell) : make("td")));
  const body = rows.map(([name, ...cells]) =>
    make("tr", {}, make("th", { scope: "row" }, name), ...cells.map((cell) => make("td", {}, cell))));
  table.replaceChildren(make("thead", {}, make("tr", {}, ...top)), make("tbody", {}, ...body));
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
