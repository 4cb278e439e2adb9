// The picture: meshes in colours or plain, lines, and a camera with parallel projection, as `billow render` draws.

import { digits } from "./elements.js";

const {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, LineBasicMaterial,
  LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrbitControls, OrthographicCamera, Plane, Raycaster, Scene,
  Vector2, Vector3, WebGLRenderer,
} = VENDOR;

const VIEWS = { iso: [-0.6, -1, 0.65], front: [0, -1, 0], side: [1, 0, 0], top: [0, 0, 1], below: [0, 0, -1] };
const TURN = 0.08, MARGIN = 1.06;

const linear = (part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4);

export class Picture {
  // colours: (256, 3) uint8, of the colour bar
  constructor(canvas, colours) {
    this.canvas = canvas;
    this.table = Float32Array.from(colours, (part) => linear(part / 255));
    this.scene = new Scene();
    this.scene.background = new Color(0xffffff);
    this.camera = new OrthographicCamera(-1, 1, 1, -1, -100, 100);
    this.camera.up.set(0, 0, 1);
    this.scene.add(new HemisphereLight(0xffffff, 0x8c8c8c, 2.3), this.camera);
    const light = new DirectionalLight(0xffffff, 1.3);
    light.position.set(-0.4, 0.7, 1);
    this.camera.add(light);
    this.half = [0.5, 0.5];
    try {
      this.renderer = new WebGLRenderer({ antialias: true, canvas });
    } catch {
      this.renderer = null;
      return;
    }
    this.renderer.setPixelRatio(Math.min(2, globalThis.devicePixelRatio || 1));
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => this.draw());
    canvas.addEventListener("keydown", (event) => this.turnedByKey(event));
    new ResizeObserver(() => this.resized()).observe(canvas.parentElement);
    this.resized();
  }

  // A mesh of triangles, each with corners of its own, so that a triangle may have one colour. holes: (triangles,),
  // which are drawn dark. wire: edges alone.
  // behind: drawn a little farther away than it is, so that fabric which lies on it is seen.
  mesh(triangles, { colour = "#ece7dd", holes = null, wire = false, opacity = 1, behind = false } = {}) {
    const geometry = new BufferGeometry(), corners = triangles.length;
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * corners), 3));
    const look = { side: DoubleSide, transparent: opacity < 1, opacity, depthWrite: opacity === 1 };
    if (behind) Object.assign(look, { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 8 });
    const material = wire
      ? new MeshBasicMaterial({ ...look, wireframe: true, color: colour })
      : new MeshLambertMaterial({ ...look, vertexColors: true, flatShading: true });
    const made = new Mesh(geometry, material);
    if (!wire) geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * corners), 3));
    made.frustumCulled = false; // its bounds change with each frame
    Object.assign(made.userData, { triangles, holes, plain: new Color(colour) });
    this.scene.add(made);
    if (!wire) this.paint(made, null);
    return made;
  }

  place(mesh, positions) {
    const { triangles } = mesh.userData, attribute = mesh.geometry.attributes.position, into = attribute.array;
    for (let i = 0, at = 0; i < triangles.length; i++) {
      const from = 3 * triangles[i];
      into[at++] = positions[from];
      into[at++] = positions[from + 1];
      into[at++] = positions[from + 2];
    }
    attribute.needsUpdate = true;
  }

  // values: of nodes or triangles, null for the plain colour; NaN is grey.
  paint(mesh, values, low = 0, high = 1, atNodes = true) {
    const { triangles, holes, plain } = mesh.userData, attribute = mesh.geometry.attributes.color, into = attribute.array;
    const span = high > low ? high - low : 1, table = this.table;
    for (let i = 0, at = 0; i < triangles.length; i++, at += 3) {
      const triangle = (i / 3) | 0;
      if (holes && holes[triangle]) {
        into[at] = into[at + 1] = into[at + 2] = 0.06;
      } else if (!values) {
        into[at] = plain.r; into[at + 1] = plain.g; into[at + 2] = plain.b;
      } else {
        const part = (values[atNodes ? triangles[i] : triangle] - low) / span;
        if (Number.isNaN(part)) { into[at] = into[at + 1] = into[at + 2] = 0.6; continue; }
        const from = 3 * Math.round(255 * Math.min(1, Math.max(0, part)));
        into[at] = table[from]; into[at + 1] = table[from + 1]; into[at + 2] = table[from + 2];
      }
    }
    attribute.needsUpdate = true;
  }

  lines(colour) {
    const made = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: colour }));
    made.frustumCulled = false;
    this.scene.add(made);
    return made;
  }

  // Leave away what lies beyond a plane [axis, place], on the side of the viewer; null for nothing.
  open(plane) {
    if (!this.renderer) return;
    if (!plane) {
      this.renderer.clippingPlanes = [];
      return;
    }
    const normal = new Vector3(), [axis, place] = plane;
    const towards = this.camera.position.clone().sub(this.orbit.target).getComponent(axis) < 0 ? 1 : -1;
    normal.setComponent(axis, towards);
    this.renderer.clippingPlanes = [new Plane(normal, -towards * (place + towards * -1e-4))];
  }

  // ends: (lines, 2, 3) [m]
  setLines(lines, ends) {
    const held = lines.geometry.attributes.position;
    if (!held || held.array.length < ends.length) {
      lines.geometry.dispose();
      lines.geometry = new BufferGeometry();
      lines.geometry.setAttribute("position", new BufferAttribute(new Float32Array(2 * ends.length), 3));
    }
    lines.geometry.attributes.position.array.set(ends);
    lines.geometry.attributes.position.needsUpdate = true;
    lines.geometry.setDrawRange(0, ends.length / 3);
  }

  // Look at a box of two corners [m] from one of VIEWS.
  look(view, box) {
    const middle = new Vector3(), away = new Vector3(...VIEWS[view]).normalize();
    middle.set(...box[0].map((low, k) => 0.5 * (low + box[1][k])));
    const size = Math.max(Math.hypot(...box[0].map((low, k) => box[1][k] - low)), 1e-6);
    this.camera.up.set(0, view === "top" || view === "below" ? 1 : 0, view === "top" || view === "below" ? 0 : 1);
    this.camera.position.copy(middle).addScaledVector(away, 4 * size);
    this.camera.near = 0;
    this.camera.far = 20 * size;
    this.camera.zoom = 1;
    this.camera.lookAt(middle);
    this.camera.updateMatrixWorld();
    this.half = [1e-6, 1e-6]; // of what is seen, to the right and upwards
    for (let corner = 0; corner < 8; corner++) {
      const seen = new Vector3(...[0, 1, 2].map((k) => box[(corner >> k) & 1][k]));
      seen.applyMatrix4(this.camera.matrixWorldInverse);
      this.half = [Math.max(this.half[0], Math.abs(seen.x)), Math.max(this.half[1], Math.abs(seen.y))];
    }
    if (!this.renderer) return;
    this.orbit.target.copy(middle);
    this.orbit.update();
    this.resized();
  }

  resized() {
    const { clientWidth: wide, clientHeight: tall } = this.canvas.parentElement;
    if (!this.renderer || !wide || !tall) return;
    this.renderer.setSize(wide, tall, false);
    const up = MARGIN * Math.max(this.half[1], (this.half[0] * tall) / wide), across = (up * wide) / tall;
    Object.assign(this.camera, { left: -across, right: across, top: up, bottom: -up });
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  turnedByKey(event) {
    const turns = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] };
    const zooms = { "+": 1.1, "=": 1.1, "-": 1 / 1.1 };
    if (event.key in zooms) this.camera.zoom *= zooms[event.key];
    else if (event.key in turns) {
      const [round, over] = turns[event.key], away = this.camera.position.clone().sub(this.orbit.target);
      const distance = away.length(), angle = Math.atan2(away.y, away.x) + round;
      const height = Math.min(1.5, Math.max(-1.5, Math.asin(away.z / distance) - over));
      away.set(Math.cos(angle) * Math.cos(height), Math.sin(angle) * Math.cos(height), Math.sin(height));
      this.camera.up.set(0, 0, 1);
      this.camera.position.copy(this.orbit.target).addScaledVector(away, distance);
    } else return;
    event.preventDefault();
    this.camera.updateProjectionMatrix();
    this.orbit.update();
    this.draw();
  }

  draw() {
    if (this.renderer) this.renderer.render(this.scene, this.camera);
  }

  // The node of a mesh nearest to where an event points, -1 for none.
  nodeAt(event, mesh) {
    if (!this.renderer) return -1;
    const box = this.canvas.getBoundingClientRect(), caster = new Raycaster();
    const x = (2 * (event.clientX - box.left)) / box.width - 1, y = 1 - (2 * (event.clientY - box.top)) / box.height;
    mesh.geometry.computeBoundingSphere();
    caster.setFromCamera(new Vector2(x, y), this.camera);
    const [hit] = caster.intersectObject(mesh);
    if (!hit) return -1;
    const corners = mesh.geometry.attributes.position, corner = new Vector3();
    let node = -1, least = Infinity;
    for (let k = 0; k < 3; k++) {
      const distance = corner.fromBufferAttribute(corners, 3 * hit.faceIndex + k).distanceTo(hit.point);
      if (distance < least) [node, least] = [mesh.userData.triangles[3 * hit.faceIndex + k], distance];
    }
    return node;
  }

  picture() {
    this.draw(); // what is drawn is there until this task ends
    return new Promise((done) => this.canvas.toBlob(done, "image/png"));
  }
}

// The colour bar with its numbers; values in `unit`.
export function drawLegend(element, colours, title, unit, low, high) {
  const [name, bar, numbers] = element.children, pen = bar.getContext("2d");
  name.textContent = `${title} [${unit}]`;
  bar.width = 256;
  bar.height = 1;
  for (let k = 0; k < 256; k++) {
    pen.fillStyle = `rgb(${colours[3 * k]}, ${colours[3 * k + 1]}, ${colours[3 * k + 2]})`;
    pen.fillRect(k, 0, 1, 1);
  }
  const parts = [0, 0.25, 0.5, 0.75, 1].map((part) => digits(low + part * (high - low)));
  numbers.replaceChildren(...parts.map((text) => Object.assign(document.createElement("span"), { textContent: text })));
}

export function boxOf(arrays) {
  const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (const positions of arrays) {
    for (let i = 0; i < positions.length; i++) {
      const k = i % 3;
      if (positions[i] < box[0][k]) box[0][k] = positions[i];
      if (positions[i] > box[1][k]) box[1][k] = positions[i];
    }
  }
  return box;
}
