// The free body of a coupled model and how the bag moves it: src/billow/rom/coupled/impactor.py and coupled_model.py.

import { Networks } from "./networks.js";
import { affineAt, superEllipsoid } from "./obstacle.js";

const REACHES = [5e-3, 20e-3], FARTHEST = 7, EVERY = 4;

// Fabric of each node [m^2] in the start shape.
export function nodeArea(reference, triangles) {
  const area = new Float64Array(reference.length / 3);
  for (let e = 0; e < triangles.length; e += 3) {
    const [a, b, c] = [triangles[e], triangles[e + 1], triangles[e + 2]];
    const [u, v] = [b, c].map((node) => [0, 1, 2].map((k) => reference[3 * node + k] - reference[3 * a + k]));
    const third = Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 6;
    for (const node of [a, b, c]) area[node] += third;
  }
  return area;
}

export class Coupled {
  constructor(tensors, record, bag) {
    const start = bag.times[0], end = bag.times.at(-1);
    Object.assign(this, { bag, name: record.coupled.name, affine: tensors["coupled.affine"] });
    this.times = tensors["coupled.times"];
    this.gravity = tensors["coupled.gravity"];
    this.stateMean = tensors["coupled.state_mean"];
    this.stateDeviation = tensors["coupled.state_deviation"];
    const [mean, deviation] = [tensors["coupled.force_mean"], tensors["coupled.force_deviation"]];
    const outputs = { times: [start, end], mean, deviation };
    const further = this.stateMean.length;
    this.law = new Networks(tensors, "coupled.", "shared", record.parameters, start, end, outputs, further);
    this.area = nodeArea(bag.reference, bag.triangles);
    this.nodes = new Float32Array(bag.reference.length);
    this.state = new Float64Array(further);
    this.centre = new Float64Array(3 * this.times.length);
    this.velocity = new Float64Array(3 * this.times.length);
  }

  // Radii, degree, centre, turn about x [rad], mass and velocity of a design.
  body(design) {
    const p = affineAt(this.affine, design);
    return {
      radii: p.slice(0, 3), degree: p[3], centre: p.slice(4, 7), turn: (p[7] * Math.PI) / 180, mass: p[8],
      velocity: p.slice(9, 12),
    };
  }

  // Fill the state: area vectors of the fabric within reach, and velocity. False if none is within reach.
  fillState(body, centre, velocity) {
    const { nodes, area, state } = this, { radii, degree, turn } = body;
    const cos = Math.cos(turn), sin = Math.sin(turn), far = FARTHEST * Math.max(...REACHES);
    state.fill(0);
    for (let i = 0; i < area.length; i++) {
      const dx = nodes[3 * i] - centre[0], dy = nodes[3 * i + 1] - centre[1], dz = nodes[3 * i + 2] - centre[2];
      const p = [dx, cos * dy + sin * dz, cos * dz - sin * dy];
      if (Math.abs(p[0]) - radii[0] >= far || Math.abs(p[1]) - radii[1] >= far || Math.abs(p[2]) - radii[2] >= far) continue;
      const size = [0, 1, 2].map((k) => Math.abs(p[k] / radii[k])), largest = Math.max(...size, 1e-12);
      const power = size.map((s) => (s / largest) ** (degree - 1));
      const sum = Math.max((power[0] * size[0] + power[1] * size[1] + power[2] * size[2]) / largest, 1e-300);
      const gauge = largest * sum ** (1 / degree), scale = sum ** (1 / degree - 1);
      const g = [0, 1, 2].map((k) => (Math.sign(p[k]) * power[k] / radii[k]) * scale);
      const steepness = Math.max(Math.hypot(...g), 1e-12), distance = Math.max((gauge - 1) / steepness, 0);
      const n = [g[0] / steepness, (cos * g[1] - sin * g[2]) / steepness, (sin * g[1] + cos * g[2]) / steepness];
      REACHES.forEach((reach, r) => {
        const weight = area[i] * Math.exp(-distance / reach);
        for (let k = 0; k < 3; k++) state[3 * r + k] -= weight * n[k];
      });
    }
    const within = state.some((value) => value !== 0);
    for (let k = 0; k < 3; k++) state[3 * REACHES.length + k] = velocity[k];
    return within;
  }

  // Motion of a design: centre and velocity at all times, (times, 3). A generator, which gives way after each step.
  *deploy(design) {
    const { times, centre, velocity, gravity } = this, body = this.body(design), last = times.length - 1;
    const interval = times[1] - times[0], { start, end } = this.law;
    centre.set(body.centre);
    velocity.set(body.velocity);
    for (let k = 0; k < last; k += EVERY) {
      const v = velocity.subarray(3 * k, 3 * k + 3), x = centre.subarray(3 * k, 3 * k + 3);
      this.bag.shape(design, Math.min(end, Math.max(start, times[k])), this.nodes);
      let force = [0, 0, 0];
      if (this.fillState(body, x, v)) {
        const scaled = this.state.map((value, s) => (value - this.stateMean[s]) / this.stateDeviation[s]);
        const middle = times[k] + 0.5 * Math.min(EVERY, last - k) * interval;
        force = this.law.mean(this.law.byMember(design, middle, scaled));
      }
      for (let at = k + 1; at <= Math.min(k + EVERY, last); at++) {
        const after = times[at] - times[k];
        for (let c = 0; c < 3; c++) {
          const acceleration = gravity[c] + force[c] / body.mass;
          centre[3 * at + c] = x[c] + after * (v[c] + 0.5 * after * acceleration);
          velocity[3 * at + c] = v[c] + after * acceleration;
        }
      }
      yield;
    }
  }

  // Points of the body's surface at a place [m], and triangles between them, for the picture.
  surface({ radii, degree, turn }, centre) {
    const cos = Math.cos(turn), sin = Math.sin(turn);
    return superEllipsoid(radii, degree, centre, [1, 0, 0, 0, cos, -sin, 0, sin, cos]);
  }
}
