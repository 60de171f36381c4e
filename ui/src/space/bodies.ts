// Shapes of a scene as objects of three.js. Axes are those of the map: x and y in the plane, z up [m].
import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  Color,
  CylinderGeometry,
  ExtrudeGeometry,
  Group,
  Mesh,
  MeshLambertMaterial,
  type Object3D,
  Shape as Outline,
  SphereGeometry,
} from "three";
import type { Spatial } from "../data/frames3";
import type { SceneEntity, Shape } from "../data/types";

const ROUND = 20; // sides of round shapes
const UNKNOWN_RADIUS = 0.15; // [m] of an entity without shapes
const UNKNOWN_HEIGHT = 0.2; // [m]

/** Make a group with shapes; its frame is that of their poses. */
export function bodyOf(shapes: Shape[], colour: string): Group {
  const group = new Group();
  for (const shape of shapes) {
    // One for each shape, also of an unknown kind: bodies are moved shape by shape.
    const mesh = new Mesh(geometryOf(shape) ?? new BufferGeometry(), materialOf(shape.color, colour));
    place(mesh, shape.pose);
    group.add(mesh);
  }
  return group;
}

/** Move an object to a pose: x, y, z [m] and a quaternion x, y, z, w. */
export function place(object: Object3D, pose: Spatial): void {
  const [x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1] = pose;
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw);
}

/** Make the body of an entity; one without shapes is its footprint, or a cylinder. */
export function entityBody(entity: SceneEntity | null, colour: string): Group {
  if (entity?.shapes?.length) return bodyOf(entity.shapes, colour);
  const height = entity?.height || UNKNOWN_HEIGHT;
  const pose = [0, 0, height / 2, 0, 0, 0, 1];
  const points = entity?.footprint ?? [];
  const isOutline = points.length >= 3;
  return bodyOf(
    [isOutline ? { kind: "polygon", pose, size: [height], points } : { kind: "cylinder", pose, size: [UNKNOWN_RADIUS, height] }],
    colour,
  );
}

function geometryOf({ kind, size, points, corners, triangles }: Shape): BufferGeometry | null {
  const [a = 0.1, b = a, c = b] = size;
  switch (kind) {
    case "box":
      return new BoxGeometry(a, b, c);
    case "sphere":
      return new SphereGeometry(a, ROUND, ROUND / 2);
    case "cylinder":
      return new CylinderGeometry(a, a, b, ROUND).rotateX(Math.PI / 2); // three.js has them along y
    case "capsule":
      return new CapsuleGeometry(a, b, ROUND / 4, ROUND).rotateX(Math.PI / 2);
    case "hull":
      return corners && triangles ? mesh(corners, triangles) : null;
    case "polygon":
      return (points?.length ?? 0) >= 3 ? prism(points!, a) : null;
    default:
      return null;
  }
}

function mesh(corners: [number, number, number][], triangles: [number, number, number][]): BufferGeometry {
  const places = triangles.flat().flatMap((index) => corners[index] ?? [0, 0, 0]);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(places), 3));
  geometry.computeVertexNormals(); // of each triangle, since they share no corners
  return geometry;
}

/** Upright prism; its origin is in the middle of its height. */
function prism(points: [number, number][], height: number): BufferGeometry {
  const outline = new Outline();
  points.forEach(([x, y], index) => (index === 0 ? outline.moveTo(x, y) : outline.lineTo(x, y)));
  return new ExtrudeGeometry(outline, { depth: height, bevelEnabled: false }).translate(0, 0, -height / 2);
}

function materialOf(colour: string | undefined, fallback: string): MeshLambertMaterial {
  const isValid = colour !== undefined && /^#[0-9a-f]{6}/i.test(colour);
  return new MeshLambertMaterial({ color: new Color(isValid ? colour.slice(0, 7) : fallback) });
}
