// The surrogate's bag: displacement, interval and volume of a design at a time.

import { CommonTime } from "./common_time.js";
import { Networks, between } from "./networks.js";

export class Bag {
  constructor(tensors, record) {
    const { times, reference, triangles, modes } = tensors;
    Object.assign(this, { times, reference, triangles, modes, closed: record.closed });
    this.nodes = reference.shape[0];
    this.count = modes.shape[1];
    const weights = tensors["clock.weights"], reach = weights && tensors["outputs.times"].at(-1);
    const clock = weights ? new CommonTime(weights, times.at(-1), reach) : null;
    const [start, end] = clock ? [0, clock.end] : [times[0], times.at(-1)];
    const outputs = {
      times: tensors["outputs.times"], mean: tensors["outputs.mean"], deviation: tensors["outputs.deviation"],
    };
    this.networks = new Networks(tensors, "", record.recipe, record.parameters, start, end, outputs, 0, clock);
    this.factors = record.interval && record.interval.factors;
    this.lostByTime = tensors.lost_by_time;
    this.lostByNode = tensors.lost_by_node;
    this.one = new Float32Array(this.nodes);
  }

  // Displacement [m] of all nodes into (nodes, 3); coefficients: of x, then y, then z.
  displacement(coefficients, into) {
    into.fill(0);
    for (let c = 0; c < 3; c++) {
      for (let k = 0; k < this.count; k++) {
        const factor = coefficients[c * this.count + k], mode = (c * this.count + k) * this.nodes;
        for (let i = 0, at = c; i < this.nodes; i++, at += 3) into[at] += factor * this.modes[mode + i];
      }
    }
    return into;
  }

  // Where the nodes are [m], (nodes, 3), and coefficients by each member.
  shape(design, time, into) {
    const members = this.networks.byMember(design, time);
    this.displacement(this.networks.mean(members), into);
    for (let i = 0; i < into.length; i++) into[i] += this.reference[i];
    return members;
  }

  // Displacement [m] of one node, three numbers.
  ofNode(coefficients, node) {
    return [0, 1, 2].map((c) => {
      let sum = 0;
      for (let k = 0; k < this.count; k++) {
        sum += coefficients[c * this.count + k] * this.modes[(c * this.count + k) * this.nodes + node];
      }
      return sum;
    });
  }

  // Half widths [m] of the interval, (nodes, 3), as `Surrogate.half_width`. first, last: nodes.
  halfWidths(members, time, into, first = 0, last = this.nodes) {
    const average = this.networks.mean(members), fewer = Math.max(members.length - 1, 1);
    const [after, part] = between(this.times, time), sum = this.one, frames = this.times.length;
    for (let c = 0; c < 3; c++) {
      for (let i = first; i < last; i++) into[3 * i + c] = 0;
      for (const member of members) {
        sum.fill(0, first, last);
        for (let k = c * this.count; k < (c + 1) * this.count; k++) {
          const away = member[k] - average[k], mode = k * this.nodes;
          for (let i = first; i < last; i++) sum[i] += away * this.modes[mode + i];
        }
        for (let i = first; i < last; i++) into[3 * i + c] += (sum[i] * sum[i]) / fewer;
      }
      const before = this.lostByTime[c * frames + after - 1];
      const lost = before + part * (this.lostByTime[c * frames + after] - before), node = c * this.nodes;
      for (let i = first; i < last; i++) {
        into[3 * i + c] = this.factors[c] * Math.sqrt(into[3 * i + c] + lost * this.lostByNode[node + i]);
      }
    }
    return into;
  }

  // Volume [m^3] that the positions enclose.
  volume(x) {
    const t = this.triangles;
    let six = 0;
    for (let e = 0; e < t.length; e += 3) {
      const a = 3 * t[e], b = 3 * t[e + 1], c = 3 * t[e + 2];
      six += x[a] * (x[b + 1] * x[c + 2] - x[b + 2] * x[c + 1]) + x[a + 1] * (x[b + 2] * x[c] - x[b] * x[c + 2])
        + x[a + 2] * (x[b] * x[c + 1] - x[b + 1] * x[c]);
    }
    return six / 6;
  }

  // Largest z [m].
  top(x) {
    let top = -Infinity;
    for (let i = 2; i < x.length; i += 3) top = Math.max(top, x[i]);
    return top;
  }
}
