// Where a plane cuts triangles, and a drawing of it in millimetres.

const NAMES = ["x", "y", "z"];
// Axes to the right and upwards in a section, by the axis of its normal.
export const ACROSS = [[1, 2], [0, 2], [0, 1]];

// Ends of the pieces, (pieces, 2, 3) [m]. axis: 0 to 2, of the normal; place: [m].
export function cut(positions, triangles, axis, place) {
  const found = [];
  for (let e = 0; e < triangles.length; e += 3) {
    const a = 3 * triangles[e], b = 3 * triangles[e + 1], c = 3 * triangles[e + 2];
    const above = (positions[a + axis] >= place) + (positions[b + axis] >= place) + (positions[c + axis] >= place);
    if (above === 0 || above === 3) continue;
    for (const [p, q] of [[a, b], [b, c], [c, a]]) {
      const from = positions[p + axis] - place, to = positions[q + axis] - place;
      if (from >= 0 === to >= 0) continue;
      const part = from / (from - to);
      for (let k = 0; k < 3; k++) found.push(positions[p + k] + part * (positions[q + k] - positions[p + k]));
    }
  }
  return Float32Array.from(found);
}

// Draw cuts into a canvas. cuts: list of {lines, colour, dashes}; box: low and high corner [m] of what is shown;
// rectangles: list of {low, high, colour}, under all else.
export function drawSection(canvas, cuts, axis, box, rectangles = []) {
  const ratio = globalThis.devicePixelRatio || 1, wide = canvas.clientWidth, tall = canvas.clientHeight;
  canvas.width = Math.round(wide * ratio);
  canvas.height = Math.round(tall * ratio);
  const pen = canvas.getContext("2d"), [right, up] = ACROSS[axis], left = 44, bottom = 34, rim = 8;
  pen.scale(ratio, ratio);
  pen.font = "11px system-ui, sans-serif";
  const span = [right, up].map((k) => Math.max(box[1][k] - box[0][k], 1e-6));
  const scale = Math.min((wide - left - rim) / span[0], (tall - bottom - rim) / span[1]);
  const x = (value) => left + (wide - left - rim - scale * span[0]) / 2 + (value - box[0][right]) * scale;
  const y = (value) => tall - bottom - (tall - bottom - rim - scale * span[1]) / 2 - (value - box[0][up]) * scale;
  const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5].find((length) => length * scale >= 42) || 10;
  pen.strokeStyle = "#dfe3e7";
  pen.fillStyle = "#41505d";
  pen.lineWidth = 1;
  pen.textAlign = "center";
  for (let value = Math.ceil(box[0][right] / step) * step; value <= box[1][right] + 1e-9; value += step) {
    stroke(pen, [[x(value), y(box[0][up])], [x(value), y(box[1][up])]]);
    pen.fillText(Math.round(value * 1e3), x(value), tall - bottom + 14);
  }
  pen.textAlign = "right";
  for (let value = Math.ceil(box[0][up] / step) * step; value <= box[1][up] + 1e-9; value += step) {
    stroke(pen, [[x(box[0][right]), y(value)], [x(box[1][right]), y(value)]]);
    pen.fillText(Math.round(value * 1e3), x(box[0][right]) - 6, y(value) + 4);
  }
  pen.textAlign = "center";
  pen.fillText(`${NAMES[right]} [mm], and ${NAMES[up]} [mm] upwards`, wide / 2, tall - 4);
  const [west, south, east, north] = [x(box[0][right]), y(box[0][up]), x(box[1][right]), y(box[1][up])];
  pen.beginPath();
  pen.rect(west - 1, north - 1, east - west + 2, south - north + 2);
  pen.clip();
  for (const { low, high, colour } of rectangles) {
    pen.fillStyle = colour;
    pen.fillRect(x(low[0]) - 0.3, y(high[1]) - 0.3, (high[0] - low[0]) * scale + 0.6, (high[1] - low[1]) * scale + 0.6);
  }
  for (const { lines, colour, dashes } of cuts) {
    pen.strokeStyle = colour;
    pen.lineWidth = 1.6;
    pen.setLineDash(dashes || []);
    pen.beginPath();
    for (let i = 0; i < lines.length; i += 6) {
      pen.moveTo(x(lines[i + right]), y(lines[i + up]));
      pen.lineTo(x(lines[i + 3 + right]), y(lines[i + 3 + up]));
    }
    pen.stroke();
  }
}

function stroke(pen, [from, to]) {
  pen.beginPath();
  pen.moveTo(...from);
  pen.lineTo(...to);
  pen.stroke();
}
