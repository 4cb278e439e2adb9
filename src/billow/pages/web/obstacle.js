// Surfaces of bodies, for the picture.

// Points of a super-ellipsoid's surface [m] and triangles between them. rotation: from its axes to space, row by row.
export function superEllipsoid(radii, degree, centre, rotation, rings = 20) {
  const points = [], triangles = [], around = 2 * rings;
  for (let i = 0; i <= rings; i++) {
    for (let j = 0; j < around; j++) {
      const up = Math.PI * (i / rings - 0.5), turn = (2 * Math.PI * j) / around;
      const d = [Math.cos(up) * Math.cos(turn), Math.cos(up) * Math.sin(turn), Math.sin(up)];
      const gauge = d.reduce((sum, x) => sum + Math.abs(x) ** degree, 0) ** (1 / degree);
      const [x, y, z] = d.map((value, k) => (radii[k] * value) / gauge);
      for (let c = 0; c < 3; c++) points.push(centre[c] + rotation[3 * c] * x + rotation[3 * c + 1] * y + rotation[3 * c + 2] * z);
      if (i < rings) {
        const a = i * around + j, b = i * around + ((j + 1) % around);
        triangles.push(a, b, a + around, b, b + around, a + around);
      }
    }
  }
  return [Float32Array.from(points), Uint32Array.from(triangles)];
}

// Numbers that are affine functions of a design. affine: (numbers, 1 + parameters), row by row.
export function affineAt(affine, design) {
  const width = 1 + design.length;
  return Array.from({ length: affine.length / width }, (_, row) =>
    design.reduce((sum, value, k) => sum + affine[row * width + 1 + k] * value, affine[row * width]));
}

// A locked obstacle: a mesh, or a super-ellipsoid whose size and place depend on the design.
export class Locked {
  constructor(tensors, k) {
    this.affine = tensors[`obstacle.${k}.affine`];
    this.fixed = [tensors[`obstacle.${k}.points`], tensors[`obstacle.${k}.triangles`]];
  }

  surface(design) {
    if (!this.affine) return this.fixed;
    const p = affineAt(this.affine, design);
    return superEllipsoid(p.slice(0, 3), p[3], p.slice(4, 7), p.slice(7, 16));
  }
}
