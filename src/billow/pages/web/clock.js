// The time that is shown: a slider over the frames, and play. Arrow keys move it by a frame, Home and End to its ends.

import { byId } from "./elements.js";

const FRAMES_PER_SECOND = 20;

export class Clock {
  // times: [s]; shown: called with the frame when it changes
  constructor(times, shown) {
    this.times = times;
    this.shown = shown;
    this.slider = byId("time");
    this.button = byId("play");
    this.slider.max = times.length - 1;
    this.slider.oninput = () => this.go(Number(this.slider.value));
    this.button.onclick = () => (this.playing ? this.stop() : this.play());
  }

  get frame() {
    return Number(this.slider.value);
  }

  get time() {
    return this.times[this.frame];
  }

  go(frame) {
    this.slider.value = frame;
    const text = `${(1e3 * this.time).toFixed(1)} ms`;
    byId("now").textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.shown();
  }

  nearest(time) {
    let best = 0;
    this.times.forEach((one, k) => { if (Math.abs(one - time) < Math.abs(this.times[best] - time)) best = k; });
    return best;
  }

  play() {
    this.playing = true;
    this.button.textContent = "Pause";
    let last = 0;
    const step = (now) => {
      if (!this.playing) return;
      if (now - last > 1e3 / FRAMES_PER_SECOND) {
        last = now;
        this.go((this.frame + 1) % this.times.length);
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  stop() {
    this.playing = false;
    this.button.textContent = "Play";
  }
}
