// The page of `billow view` and `billow compare --html`: deployments that were computed, at one time.

import { unpacked } from "./tensors.js";
import { Frames, Values } from "./frames.js";
import { Picture, boxOf, drawLegend } from "./scene.js";
import { cut, drawSection } from "./section.js";
import { Gas } from "./gas.js";
import { Plot } from "./plot.js";
import { Clock } from "./clock.js";
import { byId, choices, digits, fillTable, make, save } from "./elements.js";

const INKS = ["#0b6b52", "#b0480f", "#1f5fa8", "#8e5ea2"], DASHES = [undefined, [6, 4], [2, 3], [9, 3, 2, 3]];
const LIVE = 500; // [ms] between two sentences for screen readers

// One deployment and what is drawn of it.
class Deployment {
  constructor(tensors, told, k, picture) {
    const own = (name) => tensors[`${k}.${name}`];
    Object.assign(this, { k, label: told.label, times: Array.from(own("times")), start: own("start"), triangles: own("triangles") });
    this.frames = new Frames(own("planes"), own("box"));
    this.at = new Float32Array(3 * this.frames.points);
    this.fields = told.fields.map((field, f) => ({ ...field, values: new Values(own(`field.${f}`), field.low, field.high) }));
    this.mesh = picture.mesh(this.triangles, { holes: own("hole") });
    this.wire = picture.mesh(this.triangles, { colour: INKS[k], wire: true, opacity: 0.4 });
    this.obstacles = told.obstacles.map((name, o) => {
      const [points, triangles] = [own(`obstacle.${o}.points`), own(`obstacle.${o}.triangles`)];
      return { name, points, triangles, poses: own(`obstacle.${o}.poses`), mesh: picture.mesh(triangles, { colour: "#8aa0b4", opacity: 0.5, behind: true }), at: new Float32Array(points.length) };
    });
    this.gas = told.gas.length ? new Gas(own, told.gas) : null;
    this.straps = own("strap.planes") ? new Frames(own("strap.planes"), own("strap.box")) : null;
    this.strapLines = own("strap.lines");
    this.strapMesh = picture.lines("#b0480f");
    this.cutMesh = picture.lines("#b00020");
    this.frame = -1;
  }

  // Put everything where it is at a time [s].
  go(time) {
    this.frame = 0;
    this.times.forEach((one, k) => { if (Math.abs(one - time) < Math.abs(this.times[this.frame] - time)) this.frame = k; });
    this.frames.positions(this.frame, this.at);
    for (const { points, poses, at } of this.obstacles) {
      const p = poses.subarray(12 * this.frame, 12 * this.frame + 12);
      for (let i = 0; i < points.length; i += 3) {
        for (let c = 0; c < 3; c++) at[i + c] = p[9 + c] + p[3 * c] * points[i] + p[3 * c + 1] * points[i + 1] + p[3 * c + 2] * points[i + 2];
      }
    }
  }

  // Values of nodes or triangles to colour by.
  displacement() {
    const x = this.at, from = this.start;
    return Float32Array.from({ length: x.length / 3 }, (_, i) =>
      1e3 * Math.hypot(x[3 * i] - from[3 * i], x[3 * i + 1] - from[3 * i + 1], x[3 * i + 2] - from[3 * i + 2]));
  }

  ofStraps() {
    const x = this.straps.positions(this.frame), ends = new Float32Array(3 * this.strapLines.length);
    this.strapLines.forEach((point, k) => ends.set(x.subarray(3 * point, 3 * point + 3), 3 * k));
    return ends;
  }
}

function moved(positions, by) {
  return by ? positions.map((value, i) => (i % 3 ? value : value + by)) : positions;
}

async function start() {
  const { tensors, record } = await unpacked(byId("data").textContent.trim());
  const colours = tensors.colours, picture = new Picture(byId("picture"), colours);
  byId("nopicture").hidden = Boolean(picture.renderer);
  const bags = record.sides.map((told, k) => [told, k]).filter(([told]) => told.has_frames);
  const sides = bags.map(([told, k]) => new Deployment(tensors, told, k, picture)), many = sides.length > 1;
  byId("title").textContent = record.title;
  byId("notes").textContent = record.notes.join(" ");
  byId("together").hidden = !many;
  byId("key").hidden = record.sides.length < 2;
  byId("key").replaceChildren(...record.sides.map(({ label }, k) => make("span", { className: "abcd"[k] }, label)));

  const boxes = sides.map(({ frames: { box } }) => [[box[0], box[1], box[2]], [box[3], box[4], box[5]]]);
  const box = [0, 1].map((side) => [0, 1, 2].map((c) => (side ? Math.max : Math.min)(...boxes.map((one) => one[side][c]))));
  const span = box[1].map((high, c) => high - box[0][c]);
  const grown = box.map((corner, side) => corner.map((x, c) => x + (side ? 1 : -1) * 0.04 * (span[c] || 1e-3)));

  const names = sides[0].fields.map(({ title }, f) => [`f${f}`, title]);
  choices(byId("field"), [
    ...(record.same_mesh ? [["distance", `distance from ${sides.at(-1).label}`]] : []),
    ["displacement", "displacement"], ...names, ["none", "none"],
  ]);
  const gases = (sides.find((side) => side.gas) || { gas: { fields: [] } }).gas.fields;
  byId("gas-part").hidden = !gases.length;
  choices(byId("gas"), [...gases.map(({ title }) => [title, title]), ["none", "none"]]);
  const largest = (values) => values.reduce((most, value) => (value > most ? value : most), 0);
  let scale = null; // of displacement and distance: the largest of all frames
  const scaleOf = (kind) => {
    const here = sides[0].frame;
    let most = 1e-9;
    for (const time of sides[0].times) {
      sides.forEach((side) => side.go(time));
      const of = kind === "distance" ? sides.slice(0, -1).map(distance) : [sides[0].displacement()];
      most = Math.max(most, ...of.map(largest));
    }
    sides.forEach((side) => side.go(sides[0].times[here]));
    return { kind, most };
  };

  // Of the nodes of a bag from those of the last [mm].
  function distance(side) {
    const { at: a } = side, { at: b } = sides.at(-1);
    return Float32Array.from({ length: a.length / 3 }, (_, i) =>
      1e3 * Math.hypot(a[3 * i] - b[3 * i], a[3 * i + 1] - b[3 * i + 1], a[3 * i + 2] - b[3 * i + 2]));
  }

  // Colours of a side: values, their ends, whether of nodes, title and unit; null for none.
  function colouring(side) {
    const kind = byId("field").value;
    if (kind === "none") return null;
    if (kind[0] === "f") {
      const { title } = sides[0].fields[Number(kind.slice(1))], field = side.fields.find((one) => one.title === title);
      return field ? { values: field.values.of(side.frame), low: field.low, high: field.high, atNodes: field.at_nodes, title, unit: field.unit } : null;
    }
    if (!scale || scale.kind !== kind) scale = scaleOf(kind);
    const values = kind === "distance" ? distance(side) : side.displacement();
    return { values, low: 0, high: scale.most, atNodes: true, title: kind === "distance" ? `distance from ${sides.at(-1).label}` : kind, unit: "mm" };
  }

  const clock = new Clock(sides[0].times, shown);
  const inks = record.sides.map(({ label }, k) => ({ label, colour: INKS[k], dashes: DASHES[k] }));
  const plots = new Map();

  function plot(name, wanted) {
    const told = record.curves.find((one) => one.name === name);
    if (!wanted && plots.has(name)) {
      plots.get(name).box.remove();
      plots.delete(name);
    } else if (wanted && told && !plots.has(name)) {
      const series = told.sides.map((k) => (inks.length > 1 ? inks[k] : { ...inks[k], label: told.title }));
      const made = new Plot(byId("curves"), told.title, told.unit, series, { legend: true });
      const row = (k) => record.curves.filter((one) => one.sides.includes(k)).indexOf(told);
      const curve = (k) => {
        const all = tensors[`curves.${k}`], rows = all.shape[1], at = row(k) * rows;
        return [Array.from(tensors[`rows.${k}`]), Array.from(all.subarray(at, at + rows))];
      };
      const of = told.sides.map(curve);
      const times = [...new Set(of.flatMap(([own]) => own))].sort((a, b) => a - b);
      made.set(times, of.map((one) => along(times, one)));
      made.at(1e3 * clock.time);
      plots.set(name, made);
    }
  }

  // A curve at the times of all curves: linear in between, nothing beyond its ends.
  function along(times, [own, values]) {
    let k = 0;
    return times.map((time) => {
      if (time < own[0] || time > own.at(-1)) return null;
      while (k < own.length - 2 && own[k + 1] < time) k++;
      if (own.length < 2) return values[0];
      const part = (time - own[k]) / (own[k + 1] - own[k]);
      return values[k] + part * (values[k + 1] - values[k]);
    });
  }

  function draw() {
    const beside = many && byId("arranged").value === "beside", axis = Number(byId("axis").value);
    const place = grown[0][axis] + (byId("place").value / 100) * (grown[1][axis] - grown[0][axis]);
    byId("at").textContent = `${Math.round(1e3 * place)} mm`;
    const seen = byId("obstacles").checked, open = byId("open").checked, cuts = [];
    let legend = null;
    sides.forEach((side, k) => {
      const by = beside ? k * 1.25 * span[0] : 0, x = moved(side.at, by), solid = beside || !k;
      side.mesh.visible = solid;
      side.wire.visible = !solid;
      picture.place(solid ? side.mesh : side.wire, x);
      const lines = cut(side.at, side.triangles, axis, place);
      cuts.push({ lines, colour: INKS[side.k], dashes: DASHES[side.k] });
      picture.setLines(side.cutMesh, moved(lines, by));
      if (solid) {
        const found = byId("field").value === "distance" && side === sides.at(-1) ? null : colouring(side);
        picture.paint(side.mesh, found && found.values, found ? found.low : 0, found ? found.high : 1, found ? found.atNodes : true);
        if (!k) legend = found;
      }
      for (const obstacle of side.obstacles) {
        obstacle.mesh.visible = seen && (beside || !k);
        if (!obstacle.mesh.visible) continue;
        picture.place(obstacle.mesh, moved(obstacle.at, by));
        if (!k) cuts.push({ lines: cut(obstacle.at, obstacle.triangles, axis, place), colour: "#7b8c9b" });
      }
      side.strapMesh.visible = Boolean(side.straps) && solid;
      if (side.strapMesh.visible) picture.setLines(side.strapMesh, moved(side.ofStraps(), by));
    });
    picture.open(open ? [axis, place] : null);
    byId("legend").hidden = !legend;
    if (legend) drawLegend(byId("legend"), colours, legend.title, legend.unit, legend.low, legend.high);
    drawSection(byId("section"), cuts, axis, grown, gasAt(axis, place));
    picture.draw();
  }

  // Of the first run that has any, coloured rectangles of the gas that the plane cuts.
  function gasAt(axis, place) {
    const side = sides.find((one) => one.gas), field = side ? side.gas.fields.findIndex(({ title }) => title === byId("gas").value) : -1;
    byId("gas-legend").hidden = field < 0;
    if (field < 0) return [];
    const { title, unit, low, high } = side.gas.fields[field];
    drawLegend(byId("gas-legend"), colours, sides.length > 1 ? `${title}, ${side.label}` : title, unit, low, high);
    const ink = (step) => (step ? `rgb(${colours[3 * step]},${colours[3 * step + 1]},${colours[3 * step + 2]})` : "#999");
    return side.gas.cut(side.frame, field, axis, place).map((one) => ({ ...one, colour: ink(one.step) }));
  }

  let waiting = 0;
  function sayNow() {
    waiting = 0;
    const text = `Time ${(1e3 * clock.time).toFixed(1)} ms, height ${digits(1e3 * boxOf([sides[0].at])[1][2])} mm`;
    byId("live").textContent = text;
    byId("picture").setAttribute("aria-label", `Shape of the bag. ${text}`);
  }

  function shown() {
    sides.forEach((side) => side.go(clock.time));
    draw();
    for (const made of plots.values()) made.at(1e3 * clock.time);
    if (!waiting) waiting = setTimeout(sayNow, LIVE);
  }

  function look() {
    const wide = many && byId("arranged").value === "beside" ? [grown[0], grown[1].map((x, c) => (c ? x : x + (sides.length - 1) * 1.25 * span[0]))] : grown;
    picture.look(byId("view").value, wide);
  }

  for (const id of ["field", "axis", "obstacles", "open", "gas"]) byId(id).onchange = draw;
  byId("place").oninput = draw;
  byId("view").onchange = look;
  byId("arranged").onchange = () => { draw(); look(); };
  byId("png").onclick = async () => { if (picture.renderer) save("bag.png", await picture.picture()); };
  byId("print").onclick = () => print();
  byId("numbers-part").hidden = !record.table;
  if (record.table) fillTable(byId("numbers"), record.table.head, record.table.rows);
  byId("curves-part").hidden = !record.curves.length;
  byId("boxes").append(...record.curves.map(({ name, title, unit }) => {
    const box = make("input", { type: "checkbox", checked: record.chosen.includes(name) });
    box.onchange = () => plot(name, box.checked);
    return make("label", {}, box, ` ${title} [${unit}]`);
  }));
  for (const name of record.chosen) plot(name, true);
  look();
  clock.go(Math.round(0.6 * (sides[0].times.length - 1)));
  sayNow();
  globalThis.page = { sides, clock, picture, record, plots, distance, colouring };
  globalThis.ready = true;
}

start();
