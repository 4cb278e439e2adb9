// Curves over time by uPlot, with a mark at the time that is shown.

import { make } from "./elements.js";

const { uPlot } = VENDOR;
const GRID = { stroke: "#e3e7ea", width: 1 }, INK = "#33414d";

export class Plot {
  // series: list of {label, colour, dashes, hidden}; bands: list of [above, below, colour], by place among the series.
  // legend: whether labels and the values under the pointer are shown.
  constructor(parent, title, unit, series, { bands = [], height = 150, legend = false } = {}) {
    this.mark = NaN;
    this.parent = parent;
    this.box = make("figure", { className: "plot" });
    this.box.setAttribute("role", "img");
    this.box.setAttribute("aria-label", `${title} [${unit}] over time [ms]`);
    parent.append(this.box);
    const axis = { stroke: INK, grid: GRID, ticks: GRID, font: "11px system-ui, sans-serif" };
    this.height = height;
    this.chart = new uPlot({
      width: this.width(), height, title: `${title} [${unit}]`, scales: { x: { time: false } },
      cursor: { drag: { x: false, y: false } }, legend: { show: legend },
      axes: [{ ...axis, label: "time [ms]", labelSize: 16, size: 30, labelFont: "11px system-ui, sans-serif" }, { ...axis, size: 52 }],
      series: [
        { label: "time [ms]" },
        ...series.map(({ label = "", colour = "#0f7a5f", dashes, hidden, width = 1.6 }) => ({
          label, stroke: colour, dash: dashes, width: hidden ? 0 : width, points: { show: false },
          value: (_, value) => (value == null ? "–" : Number(value.toPrecision(4))),
        })),
      ],
      bands: bands.map(([above, below, fill]) => ({ series: [above + 1, below + 1], fill })),
      hooks: { draw: [(chart) => this.drawMark(chart)] },
    }, [[0], ...series.map(() => [null])], this.box);
    new ResizeObserver(() => this.chart.setSize({ width: this.width(), height })).observe(parent);
  }

  width() {
    return Math.max(200, this.parent.clientWidth - 2);
  }

  set(times, curves) {
    this.chart.setData([times, ...curves]);
  }

  at(time) {
    this.mark = time;
    this.chart.redraw(false);
  }

  drawMark(chart) {
    if (!Number.isFinite(this.mark) || chart.scales.x.min == null) return;
    const x = chart.valToPos(this.mark, "x", true), { top, height, left, width } = chart.bbox, pen = chart.ctx;
    if (x < left - 1 || x > left + width + 1) return;
    pen.save();
    pen.setLineDash([]);
    pen.strokeStyle = "#c0392b";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, top);
    pen.lineTo(x, top + height);
    pen.stroke();
    pen.restore();
  }
}
