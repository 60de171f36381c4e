// Outlines of shapes from above.
import { composed, placed, type Spatial } from "../data/frames3";
import type { Shape } from "../data/types";

export type Planar = [x: number, y: number];
type Point = [x: number, y: number, z: number];

const SIDES = 16; // of a circle

/** Convex outline of a shape from above [m], in the frame that a pose is given in; empty for unknown kinds. */
export function outlineOf(shape: Shape, frame: Spatial | null): Planar[] {
  const pose = frame === null ? shape.pose : composed(frame, shape.pose);
  const [a = 0.1, b = a, c = b] = shape.size;
  const seen = (points: Point[]) => points.map((point) => placed(pose, point).slice(0, 2) as Planar);
  switch (shape.kind) {
    case "box":
      return hull(seen(signs(([i, j, k]) => [(i * a) / 2, (j * b) / 2, (k * c) / 2])));
    case "sphere":
      return around(seen([[0, 0, 0]]), a);
    case "capsule":
      return around(seen([[0, 0, b / 2], [0, 0, -b / 2]]), a);
    case "cylinder":
      return hull(seen(circle(a).flatMap(([x, y]): Point[] => [[x, y, b / 2], [x, y, -b / 2]])));
    case "polygon":
      return hull(seen((shape.points ?? []).flatMap(([x, y]): Point[] => [[x, y, a / 2], [x, y, -a / 2]])));
    case "hull":
      return hull(seen(shape.corners ?? []));
    default:
      return [];
  }
}

function signs(make: (signs: [number, number, number]) => Point): Point[] {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => make([bits & 1 ? 1 : -1, bits & 2 ? 1 : -1, bits & 4 ? 1 : -1]));
}

function circle(radius: number): Planar[] {
  return Array.from({ length: SIDES }, (_, index) => {
    const angle = (2 * Math.PI * index) / SIDES;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });
}

/** Outline of discs around points. */
function around(points: Planar[], radius: number): Planar[] {
  return hull(points.flatMap(([x, y]) => circle(radius).map(([dx, dy]): Planar => [x + dx, y + dy])));
}

/** Convex hull, counterclockwise (Andrew's monotone chain). */
function hull(points: Planar[]): Planar[] {
  const sorted = [...points].sort(([ax, ay], [bx, by]) => ax - bx || ay - by);
  return [...half(sorted), ...half(sorted.reverse())];
}

function half(points: Planar[]): Planar[] {
  const found: Planar[] = [];
  for (const point of points) {
    while (found.length >= 2 && !turnsLeft(found[found.length - 2]!, found[found.length - 1]!, point)) found.pop();
    found.push(point);
  }
  return found.slice(0, -1);
}

function turnsLeft([ax, ay]: Planar, [bx, by]: Planar, [cx, cy]: Planar): boolean {
  return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0;
}
