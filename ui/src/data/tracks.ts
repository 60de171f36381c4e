// Poses of robots and bodies over time.
import type { Meta, SceneEntity } from "./types";
import { after, type Columns } from "./unpack";

export interface Pose {
  x: number;
  y: number;
  z: number;
  yaw: number;
  /** Speed over ground [m/s]. */
  speed: number;
  /** Angular speed about z [rad/s]. */
  turn: number;
}

/** Samples of one robot or body. Numbers are in steps. */
export class Track {
  readonly times: Float64Array;
  private readonly columns: Int32Array[];

  constructor(
    readonly name: string,
    readonly scene: SceneEntity | null,
    columns: Columns,
    prefix: string,
    private readonly step: number,
  ) {
    this.times = columns.reals(`${prefix}.t`);
    const fields = ["x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz"];
    this.columns = fields.map((field) => columns.integers(`${prefix}.${field}`));
  }

  get isEmpty(): boolean {
    return this.times.length === 0;
  }

  x(index: number): number {
    return this.columns[0]![index]! * this.step;
  }

  y(index: number): number {
    return this.columns[1]![index]! * this.step;
  }

  /** Whether samples have velocities; otherwise these come from differences of poses. */
  private readonly hasVelocities = lazily(() =>
    this.columns.slice(7).some((column) => column.some((value) => value !== 0)),
  );

  speed(index: number): number {
    if (this.hasVelocities()) return Math.hypot(this.columns[7]![index]!, this.columns[8]![index]!) * this.step;
    const before = index > 0 ? index - 1 : 0;
    const time = this.times[index]! - this.times[before]!;
    return time > 0 ? Math.hypot(this.x(index) - this.x(before), this.y(index) - this.y(before)) / time : 0;
  }

  private yaw(index: number): number {
    const [x, y, z, w] = [3, 4, 5, 6].map((field) => this.columns[field]![index]!) as [number, number, number, number];
    return Math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z);
  }

  /** Pose at a time, between two samples; null before the first one. */
  at(time: number): Pose | null {
    const next = after(this.times, time + 1e-9);
    if (next === 0) return null;
    const index = next - 1;
    const pose = this.sample(index);
    if (next >= this.times.length) return pose;
    const span = this.times[next]! - this.times[index]!;
    // A pause of the samples is rest, and a jump is not a way.
    const share = span > 0 && span < 1.5 ? (time - this.times[index]!) / span : 0;
    if (Math.hypot(this.x(next) - pose.x, this.y(next) - pose.y) > 1) return pose;
    const turn = wrapped(this.yaw(next) - pose.yaw);
    pose.x += share * (this.x(next) - pose.x);
    pose.y += share * (this.y(next) - pose.y);
    pose.yaw += share * turn;
    return pose;
  }

  sample(index: number): Pose {
    const z = this.columns[2]![index]! * this.step;
    const turn = this.columns[12]![index]! * this.step;
    return { x: this.x(index), y: this.y(index), z, yaw: this.yaw(index), speed: this.speed(index), turn };
  }
}

export class Tracks {
  readonly tracks: Track[];
  readonly believed: (Track | null)[];
  private readonly pathTimes: Float64Array;
  private readonly pathEntities: Int32Array;
  private readonly pathEnds: Int32Array;
  private readonly pathValues: Int32Array;

  constructor(
    private readonly meta: Meta,
    columns: Columns,
  ) {
    const scenes = new Map((meta.scene?.entities ?? []).map((entity) => [entity.name, entity]));
    // All robots are in a scene; what comes later is an object.
    const later = (name: string): SceneEntity | null => (scenes.size > 0 ? { name, kind: "object" } : null);
    this.tracks = meta.entities.map(
      ({ name }, index) => new Track(name, scenes.get(name) ?? later(name), columns, `track.${index}`, meta.step),
    );
    this.believed = meta.entities.map(({ name }, index) =>
      columns.has(`believed.${index}.t`) ? new Track(name, null, columns, `believed.${index}`, meta.step) : null,
    );
    this.pathTimes = columns.reals("paths.t");
    this.pathEntities = columns.integers("paths.entity");
    this.pathEnds = columns.integers("paths.end");
    this.pathValues = columns.integers("paths.value");
  }

  get isEmpty(): boolean {
    return this.tracks.every((track) => track.isEmpty);
  }

  /** Points of the path that a robot follows at a time. */
  path(entity: number, time: number): [number, number][] {
    for (let index = after(this.pathTimes, time + 1e-9) - 1; index >= 0; index--) {
      if (this.pathEntities[index] !== entity) continue;
      const points: [number, number][] = [];
      for (let at = index > 0 ? this.pathEnds[index - 1]! : 0; at + 1 < this.pathEnds[index]!; at += 2) {
        points.push([this.pathValues[at]! * this.meta.step, this.pathValues[at + 1]! * this.meta.step]);
      }
      return points;
    }
    return [];
  }
}

export function wrapped(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}

function lazily<T>(make: () => T): () => T {
  let found: { value: T } | null = null;
  return () => (found ??= { value: make() }).value;
}
