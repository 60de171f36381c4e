// Poses in space: x, y, z [m] and a quaternion x, y, z, w.

export type Spatial = readonly number[];
type Quaternion = [x: number, y: number, z: number, w: number];
type Point = [x: number, y: number, z: number];

function product([a, b, c, d]: Quaternion, [e, f, g, h]: Quaternion): Quaternion {
  return [
    d * e + a * h + b * g - c * f,
    d * f - a * g + b * h + c * e,
    d * g + a * f - b * e + c * h,
    d * h - a * e - b * f - c * g,
  ];
}

function rotation(pose: Spatial): Quaternion {
  const [, , , x = 0, y = 0, z = 0, w = 1] = pose;
  return [x, y, z, w];
}

function turned([x, y, z, w]: Quaternion, [px, py, pz]: Point): Point {
  const [a, b, c] = product(product([x, y, z, w], [px, py, pz, 0]), [-x, -y, -z, w]);
  return [a, b, c];
}

/** Place of a point of a frame in the parent of the frame. */
export function placed(frame: Spatial, point: Point): Point {
  const [x, y, z] = turned(rotation(frame), point);
  return [x + (frame[0] ?? 0), y + (frame[1] ?? 0), z + (frame[2] ?? 0)];
}

/** Pose in the parent of a frame. */
export function composed(frame: Spatial, pose: Spatial): Spatial {
  const [x = 0, y = 0, z = 0] = pose;
  return [...placed(frame, [x, y, z]), ...product(rotation(frame), rotation(pose))];
}

/** Pose of the parent of a frame in the frame. */
export function inverse(frame: Spatial): Spatial {
  const [x, y, z, w] = rotation(frame);
  const back: Quaternion = [-x, -y, -z, w];
  const [px, py, pz] = turned(back, [frame[0] ?? 0, frame[1] ?? 0, frame[2] ?? 0]);
  return [-px, -py, -pz, ...back];
}
