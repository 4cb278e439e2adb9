// Injury metrics of a motion, and their intervals: src/billow/injury/ and src/billow/rom/coupled/injury_metrics.py.

export const GRAVITY = 9.80665;
const CLIP = 3e-3, FITS = 1e-8, FEWEST = 200, MOST_REFINED = 30, FINEST = 1e-5, PADDING = 2;

// Mean accelerations over the intervals, three curves. velocity: (times, 3)
export function meanAcceleration(times, velocity) {
  const count = times.length - 1, interval = (times[count] - times[0]) / count;
  return [0, 1, 2].map((c) =>
    Float64Array.from({ length: count }, (_, i) => (velocity[3 * i + 3 + c] - velocity[3 * i + c]) / interval));
}

// SAE J211 filter, forwards and backwards, the curve continued by its mirror image through its ends.
export function channelFilter(curve, interval, channelClass) {
  const w = Math.tan(Math.PI * 2.0775 * channelClass * interval), whole = 1 + Math.SQRT2 * w + w * w;
  const b0 = (w * w) / whole, b1 = 2 * b0, a1 = (2 * (w * w - 1)) / whole, a2 = (1 - Math.SQRT2 * w + w * w) / whole;
  const n = curve.length, more = Math.min(n - 1, Math.ceil(PADDING / (2.0775 * channelClass * interval) - 1e-6));
  const x = new Float64Array(n + 2 * more);
  for (let i = 0; i < more; i++) {
    x[i] = 2 * curve[0] - curve[more - i];
    x[n + more + i] = 2 * curve[n - 1] - curve[n - 2 - i];
  }
  x.set(curve, more);
  const z0 = (b1 - a1 * b0 + b0 - a2 * b0) / (1 + a1 + a2), z1 = (1 + a1) * z0 - (b1 - a1 * b0);
  for (let pass = 0; pass < 2; pass++) {
    let s0 = z0 * x[0], s1 = z1 * x[0];
    for (let i = 0; i < x.length; i++) {
      const y = b0 * x[i] + s0;
      s0 = b1 * x[i] - a1 * y + s1;
      s1 = b0 * x[i] - a2 * y;
      x[i] = y;
    }
    x.reverse();
  }
  return x.slice(more, more + n);
}

// HIC of a resultant [g] of evenly spaced samples, over windows up to `longest` [s].
export function headInjury(samples, sampled, longest) {
  const parts = Math.ceil(FEWEST / samples.length), a = finer(samples, parts), interval = sampled / parts;
  const v = new Float64Array(a.length);
  for (let i = 1; i < a.length; i++) v[i] = v[i - 1] + 0.5 * interval * (a[i] + a[i - 1]);
  const curve = new Velocity(a, v, interval), end = interval * (a.length - 1), most = Math.min(longest, end);
  return Math.max(curve.refined(curve.betweenSamples(longest * (1 + FITS)), most), curve.ofLength(most));
}

function finer(samples, parts) {
  return Float64Array.from({ length: parts * (samples.length - 1) + 1 }, (_, k) => {
    const i = Math.min(Math.floor(k / parts), samples.length - 2);
    return samples[i] + (k / parts - i) * (samples[i + 1] - samples[i]);
  });
}

class Velocity {
  constructor(a, v, interval) {
    Object.assign(this, { a, v, interval, end: interval * (a.length - 1) });
  }

  at(time) {
    const i = Math.min(Math.max(Math.floor(time / this.interval), 0), this.a.length - 2), u = time - i * this.interval;
    return this.v[i] + u * (this.a[i] + ((0.5 * u) / this.interval) * (this.a[i + 1] - this.a[i]));
  }

  value(start, end) {
    return worth(this.at(end) - this.at(start), end - start);
  }

  // Windows from sample to sample that are no worse than those one sample longer, shorter, earlier or later.
  betweenSamples(longest) {
    const { v, interval } = this, count = v.length, within = Math.min(count - 1, Math.floor(longest / interval));
    const row = () => new Float64Array(count + 2).fill(-1);
    let [shorter, here, longer] = [row(), row(), row()];
    const found = [];
    for (let steps = 1; steps <= within + 1; steps++) {
      if (steps <= within) {
        for (let i = 0; i + steps < count; i++) longer[i + 1] = worth(v[i + steps] - v[i], steps * interval);
      }
      for (let i = 0; i < count; i++) {
        const value = here[i + 1];
        if (value > 0 && value >= shorter[i + 1] && value >= shorter[i + 2] && value >= longer[i + 1]
          && value >= longer[i] && value >= here[i] && value >= here[i + 2]) found.push([value, i, i + steps - 1]);
      }
      [shorter, here, longer] = [here, longer, row()];
    }
    found.sort((p, q) => q[0] - p[0] || q[1] - p[1] || q[2] - p[2]);
    return (found.length ? found.slice(0, MOST_REFINED) : [[0, 0, 1]]).map(([, s, e]) => [s * interval, e * interval]);
  }

  // The gain of a window that slides is quadratic between two moments at which an end passes a sample.
  ofLength(length) {
    const { a, interval, end } = this, starts = [end - length];
    a.forEach((_, i) => starts.push(i * interval, i * interval - length));
    const inside = [...new Set(starts.filter((s) => s >= 0 && s <= end - length))].sort((p, q) => p - q);
    const level = (time) => {
      const i = Math.min(Math.max(Math.floor(time / interval), 0), a.length - 2), u = Math.min(time / interval, a.length - 1) - i;
      return a[i] + u * (a[i + 1] - a[i]);
    };
    let best = 0;
    inside.forEach((start, k) => {
      best = Math.max(best, this.value(start, Math.min(start + length, end)));
      if (k + 1 === inside.length) return;
      const rate = level(start + length) - level(start), next = level(inside[k + 1] + length) - level(inside[k + 1]);
      if (!(rate > 0 && next < 0)) return;
      const turn = start + (rate / (rate - next)) * (inside[k + 1] - start);
      best = Math.max(best, this.value(turn, Math.min(turn + length, end)));
    });
    return best;
  }

  // The best of some windows, each moved to the best one around it.
  refined(windows, longest) {
    let best = 0;
    for (let [start, end] of windows) {
      for (let step = this.interval; step > FINEST * this.interval; step *= 0.6) {
        let most = -1, at = [start, end];
        for (const one of [-1, -0.5, 0, 0.5, 1]) {
          for (const other of [-1, -0.5, 0, 0.5, 1]) {
            const s = Math.min(Math.max(start + step * one, 0), this.end);
            const e = Math.min(Math.max(end + step * other, s), Math.min(s + longest, this.end));
            const value = this.value(s, e);
            if (value > most) [most, at] = [value, [s, e]];
          }
        }
        [start, end] = at;
      }
      best = Math.max(best, this.value(start, end));
    }
    return best;
  }
}

function worth(gain, window) {
  return window > 0 ? window * Math.max(gain / window, 0) ** 2.5 : 0;
}

// Highest level that lasts for 3 ms, summed or without interruption; 0 if the curve is shorter.
export function clip(a, interval, contiguous) {
  let low = 0, high = Math.max(...a);
  if (interval * (a.length - 1) < CLIP * (1 - FITS) || high <= 0) return 0;
  while (high - low > 1e-9 * high) {
    const middle = 0.5 * (low + high);
    if (lasted(a, interval, middle, contiguous) >= CLIP * (1 - FITS)) low = middle;
    else high = middle;
  }
  return low;
}

function lasted(a, interval, level, contiguous) {
  let run = 0, longest = 0, sum = 0;
  for (let i = 0; i + 1 < a.length; i++) {
    const from = a[i] - level, to = a[i + 1] - level, high = Math.max(from, to), low = Math.min(from, to);
    const above = interval * (high > low ? Math.min(1, Math.max(0, high / (high - low))) : Number(high > 0));
    sum += above;
    run += above;
    longest = Math.max(longest, run);
    if (!(a[i + 1] > level)) run = 0;
  }
  return contiguous ? longest : sum;
}

// HIC15, HIC36, both clips and the peak of a motion, in the order of `METRICS`.
export function metricValues(times, velocity) {
  const interval = (times.at(-1) - times[0]) / (times.length - 1);
  const filtered = meanAcceleration(times, velocity).map((curve) => channelFilter(curve, interval, 1000));
  const a = filtered[0].map((_, i) => Math.hypot(filtered[0][i], filtered[1][i], filtered[2][i]));
  const g = a.map((value) => value / GRAVITY);
  return [
    headInjury(g, interval, 0.015), headInjury(g, interval, 0.036), clip(a, interval, false) / GRAVITY,
    clip(a, interval, true) / GRAVITY, Math.max(...g),
  ];
}

// `InjuryModel`: metrics with the ends of their intervals. values: of the motion.
export function estimates(model, parameters, design, values) {
  const row = [1, ...parameters.map(({ low, high }, k) => (2 * (design[k] - low)) / (high - low) - 1)], n = row.length;
  let leverage = 1;
  row.forEach((p, i) => row.forEach((q, j) => { leverage += p * model.inverse[i * n + j] * q; }));
  return values.map((value, k) => {
    let fitted = 0;
    row.forEach((p, i) => { fitted += p * model.weights[i * values.length + k]; });
    const own = model.fromMotion[k];
    const centre = own ? Math.log(Math.max(value, model.smallest[k])) : fitted;
    const half = model.factors[k] * (own ? 1 : Math.sqrt(leverage));
    return [centre, centre - half, centre + half].map((log) => Math.exp(Math.min(700, Math.max(-700, log))));
  });
}
