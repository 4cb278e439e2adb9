// Designs: sliders with number fields, the link that names a design, and the design as TOML.

import { digits, make } from "./elements.js";

const STEPS = 400;

// The nearest value that a parameter may have: inside its range, and of a factor the number of a level.
export const clamped = (value, { low, high, levels = [] }) => {
  const inside = Math.min(high, Math.max(low, value));
  return levels.length ? Math.round(inside) : inside;
};

export class Sliders {
  // changed: called when a value changes
  constructor(parent, parameters, changed) {
    this.parameters = parameters;
    this.changed = changed;
    this.values = parameters.map((parameter) => clamped(0.5 * (parameter.low + parameter.high), parameter));
    this.fields = parameters.map((parameter, k) => this.field(parent, parameter, k));
    this.show();
  }

  field(parent, parameter, k) {
    const { label, unit, low, high, levels = [] } = parameter, id = `p${k}`;
    const step = levels.length ? 1 : (high - low) / STEPS, ends = levels.length ? levels : [digits(low), digits(high)];
    const name = unit === "-" ? label : `${label} [${unit}]`;
    const slider = make("input", { type: "range", id, min: low, max: high, step: "any" });
    const number = make("input", { type: "number", min: low, max: high, step: "any" });
    number.setAttribute("aria-label", name);
    slider.oninput = () => this.set(k, Number(slider.value));
    slider.onkeydown = (event) => { // "any" has steps of its own in each browser
      const by = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -20, PageUp: 20 }[event.key];
      if (!by) return;
      event.preventDefault();
      this.set(k, this.values[k] + by * step);
    };
    number.onchange = () => this.set(k, number.value === "" ? this.values[k] : Number(number.value));
    parent.append(make("div", { className: "slider" },
      make("label", { htmlFor: id }, name),
      make("div", { className: "row" }, slider, number),
      make("div", { className: "ends" }, ...ends.map((end) => make("span", {}, end)))));
    return { slider, number };
  }

  set(k, value) {
    this.values[k] = clamped(value, this.parameters[k]);
    this.show();
    this.changed();
  }

  setAll(values) {
    this.values = values.map((value, k) => clamped(value, this.parameters[k]));
    this.show();
    this.changed();
  }

  show() {
    this.fields.forEach(({ slider, number }, k) => {
      slider.value = this.values[k];
      number.value = Number(this.values[k].toPrecision(6));
      slider.setAttribute("aria-valuetext", this.parameters[k].levels?.[this.values[k]] ?? `${digits(this.values[k])} ${this.parameters[k].unit}`);
    });
  }
}

// Lines for `billow run --set` and for people: a table [design] of TOML.
export function toToml(title, parameters, values) {
  const plain = (text) => text.replace(/[\u0000-\u001f\u007f]/g, " ");
  const lines = parameters.map(({ name, unit }, k) => {
    const value = Number(values[k].toPrecision(9)), text = Number.isInteger(value) && Math.abs(value) < 1e15 ? `${value}.0` : String(value);
    return `${/^[A-Za-z0-9_-]+$/.test(name) ? name : JSON.stringify(name)} = ${text}  # ${plain(unit)}`;
  });
  return `# ${plain(title)}\n[design]\n${lines.join("\n")}\n`;
}

// The part of an address after "#": values by name, the time [s], and the first digits of the surrogate's sum.
export function toLink(parameters, values, time, sum) {
  const named = parameters.map(({ name }, k) => [name, String(Number(values[k].toPrecision(9)))]);
  return String(new URLSearchParams([...named, ["t", String(Number(time.toPrecision(6)))], ["of", sum.slice(0, 12)]]));
}

// What `toLink` wrote, or people: values inside the ranges, null for what is not there or no number.
export function fromLink(text, parameters, sum) {
  const told = new URLSearchParams(text);
  const number = (name) => (told.has(name) && told.get(name) !== "" && Number.isFinite(Number(told.get(name))) ? Number(told.get(name)) : null);
  const values = parameters.map((parameter) => {
    const value = number(parameter.name);
    return value === null ? null : clamped(value, parameter);
  });
  return { values, time: number("t"), stranger: told.has("of") && told.get("of") !== sum.slice(0, 12) };
}
