// The page of `billow explore`: a bag that answers while a slider moves.

import { unpacked } from "./tensors.js";
import { Bag } from "./bag.js";
import { Known } from "./standing.js";
import { Picture, boxOf, drawLegend } from "./scene.js";
import { cut, drawSection } from "./section.js";
import { Plot } from "./plot.js";
import { Clock } from "./clock.js";
import { Sliders, fromLink, toLink, toToml } from "./design.js";
import { Locked } from "./obstacle.js";
import { Coupled } from "./impactor.js";
import { GRAVITY, channelFilter, estimates, meanAcceleration, metricValues } from "./injury.js";
import { byId, choices, digits, fillTable, save } from "./elements.js";

const A = "#0b6b52", B = "#b0480f", BAND = "rgba(11,107,82,.16)", DASHES = [6, 4];
const SLICE = 8, LIVE = 500; // [ms]: of work between two pictures, and between two sentences for screen readers

async function start() {
  const { tensors, record } = await unpacked(byId("data").textContent.trim());
  const bag = new Bag(tensors, record), { parameters } = record, known = new Known(tensors.known, record.usual, record.largest);
  const coupled = record.coupled ? new Coupled(tensors, record, bag) : null;
  const colours = tensors.colours, times = Array.from(bag.times), ms = times.map((time) => 1e3 * time);
  const at = new Float32Array(3 * bag.nodes), other = new Float32Array(3 * bag.nodes), widths = new Float32Array(3 * bag.nodes);
  const value = new Float32Array(bag.nodes), scratch = new Float32Array(3 * bag.nodes);
  let b = null, node = record.node, curvesOf = null;

  byId("title").textContent = record.title;
  byId("verdict").textContent = record.verdict;
  byId("verdict").classList.toggle("warning", record.lost);
  const hidden = record.obstacles.filter(({ drawn }) => !drawn).map(({ name }) => name).join(", ");
  const undrawn = hidden && ` Not drawn, as its surface changes with the design: ${hidden}.`;
  byId("source").textContent = `Surrogate of ${record.runs} runs, ${bag.nodes} nodes, SHA-256 ${record.sha256.slice(0, 16)}… Billow ${record.version}.${undrawn}`;

  // The box that the bag of some designs needs: its corners decide what cameras and sections show.
  const corners = [0, 0.5, 1].flatMap((u) => [0.3, 0.6, 1].map((v) => [u, v]));
  const shapes = corners.map(([u, v]) => {
    const x = new Float32Array(3 * bag.nodes);
    bag.shape(parameters.map(({ low, high }) => low + u * (high - low)), times[Math.round(v * (times.length - 1))], x);
    return x;
  });
  const box = boxOf(shapes);
  const grown = box.map((corner, side) => corner.map((x, k) => x + (side ? 1 : -1) * 0.05 * (box[1][k] - box[0][k])));

  const picture = new Picture(byId("picture"), colours);
  byId("nopicture").hidden = Boolean(picture.renderer);
  const mesh = picture.mesh(bag.triangles, { holes: tensors.hole });
  const wire = picture.mesh(bag.triangles, { colour: B, wire: true, opacity: 0.35 });
  wire.visible = false;
  const line = picture.lines("#b00020");
  const bodies = record.obstacles.map((told, k) => ({ ...told, body: new Locked(tensors, k), mesh: null })).filter(({ drawn }) => drawn);
  let head = null;

  const fields = [["displacement", "displacement"], ["speed", "speed"], ...(bag.factors ? [["interval", "half width of the interval"]] : []), ["none", "none"]];
  const field = byId("field"), axis = byId("axis"), place = byId("place");
  choices(field, fields);
  const heights = [{ label: "A", colour: A }, { label: "B", colour: B, dashes: DASHES }];
  const plots = {
    volume: bag.closed ? new Plot(byId("curves"), "Volume", "l", heights) : null,
    top: new Plot(byId("curves"), "Largest height", "mm", heights),
    node: new Plot(byId("curves"), "Node along z", "mm",
      [{ colour: A, label: "A" }, { colour: B, dashes: DASHES, label: "B" }, { hidden: true }, { hidden: true }], { bands: [[2, 3, BAND]] }),
  };
  if (coupled) {
    const bands = { bands: [[2, 3, BAND]] }, four = [...heights, { hidden: true }, { hidden: true }];
    plots.acceleration = new Plot(byId("curves"), `Acceleration of ${record.coupled.name} along z, CFC 60`, "g", four, bands);
    plots.velocity = new Plot(byId("curves"), `Velocity of ${record.coupled.name} along z`, "m/s", four, bands);
  }
  byId("node").max = bag.nodes - 1;

  const sliders = new Sliders(byId("sliders"), parameters, moved);
  const clock = new Clock(times, shown);

  // What is seen at once: shape, colours and section of the time that is shown. Returns [ms] of work without drawing.
  function answer() {
    const begun = performance.now(), time = clock.time, members = bag.shape(sliders.values, time, at);
    const kind = field.value;
    let low = 0, high = 0;
    if (kind === "interval") {
      bag.halfWidths(members, time, widths);
      for (let i = 0; i < value.length; i++) value[i] = 1e3 * Math.hypot(widths[3 * i], widths[3 * i + 1], widths[3 * i + 2]);
    } else if (kind === "displacement") {
      for (let i = 0; i < value.length; i++) value[i] = 1e3 * away(at, bag.reference, i);
    } else if (kind === "speed") {
      const [from, to] = [times[Math.max(0, clock.frame - 1)], times[Math.min(times.length - 1, clock.frame + 1)]];
      bag.shape(sliders.values, from, scratch);
      bag.shape(sliders.values, to, other);
      for (let i = 0; i < value.length; i++) value[i] = away(other, scratch, i) / (to - from);
    }
    if (b) bag.shape(b, time, other);
    if (kind === "difference") for (let i = 0; i < value.length; i++) value[i] = 1e3 * away(at, other, i);
    for (let i = 0; i < value.length; i++) high = Math.max(high, value[i]);
    picture.place(mesh, at);
    picture.paint(mesh, kind === "none" ? null : value, low, high);
    const [unit, title] = { speed: ["m/s", "speed"], interval: ["mm", `half width of the ${100 * (record.interval ? record.interval.level : 0)} % interval`], difference: ["mm", "distance between A and B"] }[kind] || ["mm", "displacement"];
    byId("legend").hidden = kind === "none";
    drawLegend(byId("legend"), colours, title, unit, low, high);
    const across = Number(axis.value), where = grown[0][across] + (place.value / 100) * (grown[1][across] - grown[0][across]);
    const ends = cut(at, bag.triangles, across, where);
    const spent = performance.now() - begun;
    picture.setLines(line, ends);
    byId("at").textContent = `${Math.round(1e3 * where)} mm`;
    if (b) picture.place(wire, other);
    const cuts = [{ lines: ends, colour: A }];
    if (b) cuts.push({ lines: cut(other, bag.triangles, across, where), colour: B, dashes: DASHES });
    for (const body of [placeHead(), ...bodies.map(placeBody)]) if (body) cuts.push({ lines: cut(body[0], body[1], across, where), colour: "#44576a" });
    drawSection(byId("section"), cuts, across, grown);
    picture.draw();
    return spent;
  }

  function away(x, y, i) {
    return Math.hypot(x[3 * i] - y[3 * i], x[3 * i + 1] - y[3 * i + 1], x[3 * i + 2] - y[3 * i + 2]);
  }

  function placeBody(locked) {
    const [points, triangles] = locked.body.surface(sliders.values);
    if (!locked.mesh) locked.mesh = picture.mesh(triangles, { colour: "#8aa0b4", opacity: 0.55, behind: true });
    picture.place(locked.mesh, points);
    return [points, triangles];
  }

  function placeHead() {
    if (!coupled || !curvesOf || !curvesOf.motion) return null;
    const row = Math.round((clock.time - coupled.times[0]) / (coupled.times[1] - coupled.times[0]));
    const k = Math.min(Math.max(row, 0), coupled.times.length - 1), centre = curvesOf.motion.centre.slice(3 * k, 3 * k + 3);
    const [points, triangles] = coupled.surface(coupled.body(sliders.values), centre);
    if (!head) head = picture.mesh(triangles, { colour: "#8aa0b4", opacity: 0.55, behind: true });
    picture.place(head, points);
    return [points, triangles];
  }

  // Curves of a design, in slices, so that a slider moves on: a generator, which returns them.
  function* curves(design) {
    const found = { volume: [], top: [], node: [], width: [], motion: null }, half = new Float32Array(3 * bag.nodes);
    for (const time of times) {
      const members = bag.shape(design, time, scratch);
      found.top.push(1e3 * bag.top(scratch));
      if (bag.closed) found.volume.push(1e3 * Math.abs(bag.volume(scratch)));
      found.node.push(1e3 * (scratch[3 * node + 2] - bag.reference[3 * node + 2]));
      if (bag.factors) found.width.push(1e3 * bag.halfWidths(members, time, half, node, node + 1)[3 * node + 2]);
      yield;
    }
    if (coupled) {
      yield* coupled.deploy(design);
      const interval = coupled.times[1] - coupled.times[0], centre = coupled.centre.slice(), velocity = coupled.velocity.slice();
      const acceleration = channelFilter(meanAcceleration(coupled.times, velocity)[2], interval, 60);
      const values = metricValues(coupled.times, velocity);
      const metrics = record.coupled.injury ? estimates(injuryModel, parameters, design, values) : values.map((one) => [one, NaN, NaN]);
      found.motion = { centre, velocity, acceleration, metrics };
    }
    return found;
  }

  const injuryModel = record.coupled && record.coupled.injury && {
    weights: tensors["coupled.injury.weights"], inverse: tensors["coupled.injury.inverse"],
    smallest: tensors["coupled.injury.smallest"], factors: tensors["coupled.injury.factors"],
    fromMotion: tensors["coupled.injury.from_motion"],
  };

  let question = 0, ofB = null;
  // Newest question wins: an older one is given up at its next slice.
  function ask() {
    const mine = ++question, work = (function* () {
      const ofA = yield* curves(sliders.values.slice());
      if (b && !ofB) ofB = yield* curves(b);
      return ofA;
    })();
    (function slice() {
      if (mine !== question) return;
      const begun = performance.now();
      for (;;) {
        const { done, value: found } = work.next();
        if (done) {
          curvesOf = found;
          drawCurves();
          answer();
          return;
        }
        if (performance.now() - begun > SLICE) break;
      }
      requestAnimationFrame(slice);
    })();
  }

  const nothing = times.map(() => null);

  function drawCurves() {
    const two = (name) => [curvesOf[name], b && ofB ? ofB[name] : nothing];
    if (plots.volume) plots.volume.set(ms, two("volume"));
    plots.top.set(ms, two("top"));
    const band = bag.factors ? [1, -1].map((sign) => curvesOf.node.map((z, k) => z + sign * curvesOf.width[k])) : [nothing, nothing];
    plots.node.set(ms, [...two("node"), ...band]);
    if (coupled) {
      const empty = Array.from(coupled.times, () => null), clockwise = Array.from(coupled.times, (time) => 1e3 * time);
      const mean = (of) => (of ? [of.motion.acceleration[0], ...of.motion.acceleration].map((x) => x / GRAVITY) : empty);
      const speed = (of) => (of ? Array.from(coupled.times, (_, k) => of.motion.velocity[3 * k + 2]) : empty);
      const draw = (plot, a, other2, name, factor) => {
        const half = tensors[`half_width.${name}`];
        const ends = half ? [1, -1].map((sign) => a.map((x, k) => x + sign * factor * half[k])) : [empty, empty];
        plot.set(clockwise, [a, other2, ...ends]);
      };
      const there = b && ofB;
      draw(plots.acceleration, mean(curvesOf), mean(there), "acceleration", 1 / GRAVITY);
      draw(plots.velocity, speed(curvesOf), speed(there), "velocity", 1);
    }
    for (const plot of Object.values(plots)) if (plot) plot.at(1e3 * clock.time);
    drawNumbers();
  }

  function drawNumbers() {
    const rows = [], k = clock.frame, of = (found, name) => (found ? digits(name(found)) : "–"), there = b && ofB;
    const add = (title, name) => {
      const row = [title, of(curvesOf, name)];
      if (b) row.push(of(there, name), there ? digits(name(curvesOf) - name(there)) : "–");
      rows.push(row);
    };
    if (bag.closed) add("Volume now [l]", (found) => found.volume[k]);
    if (bag.closed) add("Largest volume [l]", (found) => Math.max(...found.volume));
    add("Height now [mm]", (found) => found.top[k]);
    add("Largest height [mm]", (found) => Math.max(...found.top));
    if (coupled) {
      record.coupled.metrics.forEach(({ name, usable }, m) => {
        const cell = (found) => {
          if (!found) return "–";
          const [x, low, high] = found.motion.metrics[m];
          return Number.isFinite(low) ? `${digits(x)} (${digits(low)} to ${digits(high)})` : digits(x);
        };
        const row = [usable ? name : `${name}, not usable`, cell(curvesOf)];
        if (b) row.push(cell(there), there ? digits(curvesOf.motion.metrics[m][0] - there.motion.metrics[m][0]) : "–");
        rows.push(row);
      });
    }
    fillTable(byId("numbers"), b ? ["", "A", "B", "A − B"] : ["", "A"], rows);
  }

  let waiting = 0;
  function tell() {
    if (!waiting) waiting = setTimeout(sayNow, LIVE);
  }

  function sayNow() {
    waiting = 0;
    const height = 1e3 * bag.top(at), volume = bag.closed ? `, volume ${digits(1e3 * Math.abs(bag.volume(at)))} l` : "";
    byId("live").textContent = `Time ${(1e3 * clock.time).toFixed(1)} ms${volume}, height ${digits(height)} mm`;
    byId("picture").setAttribute("aria-label", `Shape of the bag. ${byId("live").textContent}`);
  }

  function shown() {
    answer();
    for (const plot of Object.values(plots)) if (plot) plot.at(1e3 * clock.time);
    if (curvesOf) drawNumbers();
    tell();
    link();
  }

  function moved() {
    const [text, warning] = known.says(sliders.values, parameters);
    byId("standing").textContent = text;
    byId("standing").classList.toggle("warning", warning);
    answer();
    ask();
    tell();
    link();
  }

  function link() {
    try {
      history.replaceState(null, "", `#${toLink(parameters, sliders.values, clock.time, record.sha256)}`);
    } catch { /* a page inside another has no address of its own */ }
  }

  function setB(design) {
    b = design;
    ofB = null;
    wire.visible = Boolean(b);
    byId("swap").disabled = byId("drop").disabled = !b;
    const kept = field.value;
    choices(field, b ? [["difference", "distance between A and B"], ...fields] : fields);
    field.value = kept === "difference" && !b ? "displacement" : kept;
  }

  byId("interval").textContent = record.interval
    ? `${100 * record.interval.level} % of the solver's values lie within the shaded bands and the half widths of the colours, on average over unseen designs.`
    : "This surrogate has no intervals: how far an answer may be off is not known.";
  if (record.coupled) byId("injury").textContent = record.coupled.verdict;
  byId("reset").onclick = () => sliders.setAll(parameters.map(({ low, high }) => 0.5 * (low + high)));
  byId("keep").onclick = () => { setB(sliders.values.slice()); moved(); };
  byId("swap").onclick = () => { const kept = b; setB(sliders.values.slice()); sliders.setAll(kept); };
  byId("drop").onclick = () => { setB(null); moved(); };
  byId("view").onchange = () => picture.look(byId("view").value, grown);
  for (const control of [field, axis]) control.onchange = () => answer();
  place.oninput = () => answer();
  byId("node").onchange = () => { chooseNode(Number(byId("node").value)); };
  function chooseNode(wanted) {
    node = Math.min(bag.nodes - 1, Math.max(0, Math.round(wanted) || 0));
    byId("node").value = node;
    ofB = null;
    ask();
  }
  let pressed = null;
  byId("picture").addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  byId("picture").addEventListener("pointerup", (event) => {
    if (!pressed || Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;
    const found = picture.nodeAt(event, mesh);
    if (found >= 0) chooseNode(found);
  });
  const toml = () => toToml(record.title, parameters, sliders.values);
  byId("toml").onclick = () => save("design.toml", toml(), "text/plain");
  byId("png").onclick = async () => { if (picture.renderer) save("bag.png", await picture.picture()); };
  byId("print").onclick = () => print();
  byId("link").onclick = async () => {
    try {
      await navigator.clipboard.writeText(location.href);
      byId("told").textContent = "copied";
    } catch {
      byId("told").textContent = "the address of this page is the link";
    }
  };

  function follow() {
    const told = fromLink(location.hash.slice(1), parameters, record.sha256);
    if (told.stranger) byId("told").textContent = "This link was made for another surrogate: the same numbers may mean another answer.";
    clock.slider.value = told.time === null ? Math.round(0.6 * (times.length - 1)) : clock.nearest(told.time);
    sliders.setAll(told.values.map((one, k) => (one === null ? sliders.values[k] : one)));
    clock.go(clock.frame);
  }
  globalThis.addEventListener("hashchange", follow);
  byId("node").value = node;
  picture.look("iso", grown);
  follow();
  sayNow();

  // For the tests of these pages.
  globalThis.page = {
    bodies,
    bag, coupled, sliders, clock, answer, toml, curves, picture, chooseNode, known,
    displacement: (design, time) => Array.from(bag.displacement(bag.networks.mean(bag.networks.byMember(design, time)), scratch)),
    halfWidths: (design, time) => Array.from(bag.halfWidths(bag.networks.byMember(design, time), time, new Float32Array(3 * bag.nodes))),
    curvesOf: () => curvesOf, metricValues,
  };
  globalThis.ready = true;
}

start();
