// Frames as they are packed by src/billow/pages/packed.py: differences from frame to frame, bytes in planes.

export class Frames {
  // planes: (2, frames, 3, points) uint8; box: (2, 3) [m]
  constructor(planes, box) {
    const [, frames, , points] = planes.shape, size = 3 * points, all = frames * size;
    Object.assign(this, { box, frames, points });
    this.steps = new Uint16Array(all);
    for (let i = 0; i < all; i++) {
      const step = planes[i] + 256 * planes[all + i];
      this.steps[i] = i < size ? step : this.steps[i - size] + step;
    }
  }

  // Positions [m] of a frame into (points, 3).
  positions(frame, into = new Float32Array(3 * this.points)) {
    for (let c = 0; c < 3; c++) {
      const low = this.box[c], step = (this.box[3 + c] - low) / 65535, from = (3 * frame + c) * this.points;
      for (let i = 0, at = c; i < this.points; i++, at += 3) into[at] = low + step * this.steps[from + i];
    }
    return into;
  }
}

export class Values {
  // bytes: (frames, n) uint8; low, high: what 1 and 255 mean, 0 is no number
  constructor(bytes, low, high) {
    const [frames, count] = bytes.shape;
    Object.assign(this, { low, high, count });
    this.steps = new Uint8Array(frames * count);
    for (let i = 0; i < this.steps.length; i++) this.steps[i] = i < count ? bytes[i] : this.steps[i - count] + bytes[i];
  }

  of(frame) {
    const step = (this.high - this.low) / 254;
    return Float32Array.from(this.steps.subarray(frame * this.count, (frame + 1) * this.count),
      (value) => (value ? this.low + step * (value - 1) : NaN));
  }
}
