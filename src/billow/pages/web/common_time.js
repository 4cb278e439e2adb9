// The clock of a design: src/billow/rom/surrogate/clock.py, line by line.

const LATEST_PART = 1.5, LARGEST_RATE = Math.log(4);

export class CommonTime {
  // weights: (terms, parts); last: [s], the last trained own time; reach: [s], common time that the runs got to.
  constructor(weights, last, reach) {
    Object.assign(this, { weights, last, reach, end: LATEST_PART * last, parts: weights.shape[1] });
  }

  // Common time [s] of an own time [s] of a design. parameters: with low and high.
  of(parameters, design, time) {
    const centred = parameters.map(({ low, high }, k) => 2 * (design[k] - low) / (high - low) - 1);
    const terms = [1, ...centred];
    centred.forEach((one, i) => { for (let j = i; j < centred.length; j++) terms.push(one * centred[j]); });
    const part = this.last / this.parts;
    let common = 0;
    for (let p = 0; p < this.parts; p++) {
      let rate = 0;
      for (let k = 0; k < terms.length; k++) rate += terms[k] * this.weights[k * this.parts + p];
      const longest = p < this.parts - 1 ? part : Infinity;
      const spent = Math.min(longest, Math.max(0, time - p * part));
      common += Math.exp(Math.min(LARGEST_RATE, Math.max(-LARGEST_RATE, rate))) * spent;
    }
    return Math.min(this.end, this.reach, Math.max(0, common));
  }
}
