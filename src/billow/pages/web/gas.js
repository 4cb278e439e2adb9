// The gas where it is known place by place: boxes that a plane cuts, in colours (src/billow/pages/gas.py).

import { ACROSS } from "./section.js";

export class Gas {
  // own: name -> array of the page; fields: what they are
  constructor(own, fields) {
    Object.assign(this, { corners: own("gas.corners"), box: own("gas.box"), starts: own("gas.starts"), fields });
    this.values = fields.map((_, k) => own(`gas.${k}`));
  }

  // Of a frame, rectangles that a plane across `axis` at `place` [m] cuts: {low, high [m], step: 1 to 255, 0 for no number}.
  cut(frame, field, axis, place) {
    const { corners, box, starts } = this, [right, up] = ACROSS[axis], found = [];
    const at = (i, k) => box[k] + (corners[6 * i + k] / 65535) * (box[3 + k] - box[k]);
    const end = (i, k) => box[k] + (corners[6 * i + 3 + k] / 65535) * (box[3 + k] - box[k]);
    for (let i = starts[frame]; i < starts[frame + 1]; i++) {
      if (at(i, axis) > place || end(i, axis) <= place) continue;
      found.push({ low: [at(i, right), at(i, up)], high: [end(i, right), end(i, up)], step: this.values[field][i] });
    }
    return found;
  }
}
