// Where a design stands among the trained ones: `Standing` of src/billow/rom/surrogate/design_space.py.

export class Known {
  // designs: (runs, parameters), distinct, every range scaled to [0, 1]; usual, largest: distances between neighbours.
  constructor(designs, usual, largest) {
    Object.assign(this, { designs, usual, largest });
  }

  nearest(design, parameters) {
    const width = parameters.length;
    let least = Infinity;
    for (let run = 0; run < this.designs.shape[0]; run++) {
      let sum = 0;
      parameters.forEach(({ low, high }, k) => {
        sum += ((design[k] - low) / (high - low) - this.designs[run * width + k]) ** 2;
      });
      least = Math.min(least, Math.sqrt(sum));
    }
    return least;
  }

  // A sentence, and whether it is a warning.
  says(design, parameters) {
    if (!this.designs.shape[0]) return ["", false];
    const nearest = this.nearest(design, parameters), isolated = nearest > this.largest;
    const told = `Inside the trained ranges. The nearest training design is ${nearest.toFixed(2)} away `
      + `(they are ${this.usual.toFixed(2)} from each other on average, ${this.largest.toFixed(2)} at most; every `
      + "range counts as 1).";
    if (!isolated) return [told, false];
    return [`${told} That is farther than any of them is from the others: the answer is less certain than its interval.`, true];
  }
}
