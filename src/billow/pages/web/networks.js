// Trained networks of equal shape, and their scalings: src/billow/rom/surrogate/regression.py, line by line.

const FREQUENCIES = [1, 2, 4, 8], BY_CLOCK = [...FREQUENCIES, 16, 32];

// x / (1 + exp(-x)) and tanh, in place.
const ACTIVATIONS = {
  shared: (x) => { for (let i = 0; i < x.length; i++) x[i] /= 1 + Math.exp(-x[i]); },
  paper: (x) => { for (let i = 0; i < x.length; i++) x[i] = Math.tanh(x[i]); },
};

// Index of the interval between rising times that holds `time`, and the part of it that has passed.
export function between(times, time) {
  let after = 1;
  while (after < times.length - 1 && times[after] < time) after++;
  const part = (time - times[after - 1]) / (times[after] - times[after - 1]);
  return [after, Math.min(1, Math.max(0, part))];
}

export class Networks {
  // parameters: with low and high; start, end: [s]; outputs: times, mean and deviation; further: inputs besides;
  // clock: of a design, in whose common time start, end and times of outputs are then.
  constructor(tensors, prefix, recipe, parameters, start, end, outputs, further = 0, clock = null) {
    Object.assign(this, { recipe, parameters, start, end, outputs, clock });
    this.frequencies = clock ? BY_CLOCK : FREQUENCIES;
    this.weights = [];
    this.biases = [];
    for (let layer = 0; `${prefix}weights.${layer}` in tensors; layer++) {
      this.weights.push(tensors[`${prefix}weights.${layer}`]);
      this.biases.push(tensors[`${prefix}biases.${layer}`]);
    }
    const [count, width] = this.weights[0].shape, last = this.weights.at(-1).shape[2];
    this.count = count;
    this.members = recipe === "shared" ? count : 1;
    this.size = recipe === "shared" ? last : count;
    this.known = width - further;
    this.inputs = new Float32Array(width);
    this.layers = this.weights.map((weight) => new Float32Array(weight.shape[2]));
    this.answers = Array.from({ length: this.members }, () => new Float32Array(this.size));
    this.average = new Float32Array(this.size);
  }

  // Outputs by each member; the arrays are used again by the next question.
  byMember(design, own, further = []) {
    const time = this.clock ? this.clock.of(this.parameters, design, own) : own;
    this.fillInputs(design, time, further);
    for (let network = 0; network < this.count; network++) {
      const answer = this.through(network);
      if (this.recipe === "shared") this.answers[network].set(answer);
      else this.answers[0][network] = answer[0];
    }
    const { times, mean, deviation } = this.outputs, size = this.size;
    const [after, part] = between(times, time), a = (after - 1) * size, b = after * size;
    for (const answer of this.answers) {
      for (let j = 0; j < size; j++) {
        const middle = mean[a + j] + part * (mean[b + j] - mean[a + j]);
        const spread = deviation[a + j] + part * (deviation[b + j] - deviation[a + j]);
        answer[j] = answer[j] * spread + middle;
      }
    }
    return this.answers;
  }

  mean(answers) {
    this.average.fill(0);
    for (const answer of answers) for (let j = 0; j < this.size; j++) this.average[j] += answer[j] / this.members;
    return this.average;
  }

  fillInputs(design, time, further) {
    const x = this.inputs, shared = this.recipe === "shared";
    let i = 0;
    this.parameters.forEach(({ low, high }, k) => {
      const unit = (design[k] - low) / (high - low);
      x[i++] = shared ? 2 * unit - 1 : unit;
    });
    const unit = (time - this.start) / (this.end - this.start);
    x[i++] = unit;
    if (shared) {
      for (const frequency of this.frequencies) x[i++] = Math.sin(Math.PI * frequency * unit);
      for (const frequency of this.frequencies) x[i++] = Math.cos(Math.PI * frequency * unit);
    }
    for (const value of further) x[i++] = value;
  }

  through(network) {
    let from = this.inputs;
    for (let layer = 0; layer < this.weights.length; layer++) {
      const weight = this.weights[layer], to = this.layers[layer], width = to.length;
      const bias = this.biases[layer].subarray(network * width, (network + 1) * width);
      const begin = network * from.length * width;
      to.set(bias);
      for (let i = 0; i < from.length; i++) {
        const value = from[i], row = begin + i * width;
        for (let j = 0; j < width; j++) to[j] += value * weight[row + j];
      }
      if (layer < this.weights.length - 1) ACTIVATIONS[this.recipe](to);
      from = to;
    }
    return from;
  }
}
