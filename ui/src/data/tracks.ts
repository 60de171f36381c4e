// Poses of robots and bodies over time.
import { composed, inverse, type Spatial } from "./frames3";
import { Scans } from "./scans";
import type { Meta, SceneEntity, Shape } from "./types";
import { after, type Columns, grown } from "./unpack";

export interface Pose {
  /** Time of the run [s]. */
  time: number;
  x: number;
  y: number;
  z: number;
  yaw: number;
  /** Speed over ground [m/s]. */
  speed: number;
  /** Angular speed about z [rad/s]. */
  turn: number;
}

const FIELDS = ["x", "y", "z", "qx", "qy", "qz", "qw", "vx", "vy", "vz", "wx", "wy", "wz"];
type Quaternion = [x: number, y: number, z: number, w: number];
const VELOCITY = 7; // index of the first velocity

/** Samples of one robot or body. Numbers are in steps. */
export class Track {
  times = new Float64Array(0);
  /** Links that move against the base. */
  readonly links = new Map<string, Track>();
  private readonly columns: Int32Array<ArrayBuffer>[] = FIELDS.map(() => new Int32Array(0));
  /** Whether samples have velocities; otherwise these come from differences of poses. */
  private hasVelocities = false;
  private known = new Float64Array(0);

  constructor(
    readonly name: string,
    public scene: SceneEntity | null,
    private readonly step: number,
  ) {}

  append(columns: Columns, prefix: string): void {
    this.times = grown(this.times, columns.reals(`${prefix}.t`));
    FIELDS.forEach((field, index) => {
      const more = columns.integers(`${prefix}.${field}`);
      this.columns[index] = grown(this.columns[index]!, more);
      if (index >= VELOCITY) this.hasVelocities ||= more.some((value) => value !== 0);
    });
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

  z(index: number): number {
    return this.columns[2]![index]! * this.step;
  }

  speed(index: number): number {
    if (this.hasVelocities) return Math.hypot(this.columns[7]![index]!, this.columns[8]![index]!) * this.step;
    const before = index > 0 ? index - 1 : 0;
    const time = this.times[index]! - this.times[before]!;
    return time > 0 ? Math.hypot(this.x(index) - this.x(before), this.y(index) - this.y(before)) / time : 0;
  }

  /** Speed over ground of all samples [m/s]. */
  speeds(): Float64Array<ArrayBuffer> {
    if (this.known.length < this.times.length) this.known = grown(this.known, this.speedsFrom(this.known.length));
    return this.known;
  }

  private speedsFrom(first: number): Float64Array<ArrayBuffer> {
    return Float64Array.from({ length: this.times.length - first }, (_, index) => this.speed(first + index));
  }

  private yaw(index: number): number {
    const [x, y, z, w] = [3, 4, 5, 6].map((field) => this.columns[field]![index]!) as Quaternion;
    return Math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z);
  }

  /** Whether the poses at a time are those of an odometry, whose origin in the map is unknown. */
  isByOdometry(time: number): boolean {
    const frames = this.scene?.frames ?? [];
    const [, frame = "map"] = frames.filter(([begin]) => begin <= time + 1e-9).at(-1) ?? [];
    return frame !== "map";
  }

  /** Name for pictures at a time, with what people must know of its pose. */
  labelAt(time: number, name = this.name): string {
    const marks = [this.scene?.real ? "real" : "", this.isByOdometry(time) ? "by odometry" : ""].filter(Boolean);
    return marks.length > 0 ? `${name} (${marks.join(", ")})` : name;
  }

  /** Samples around a time, and the share of the later one; null before the first sample. */
  private around(time: number): [index: number, next: number, share: number] | null {
    const next = after(this.times, time + 1e-9);
    if (next === 0) return null;
    const index = next - 1;
    if (next >= this.times.length) return [index, index, 0];
    const span = this.times[next]! - this.times[index]!;
    // A pause of the samples is rest, and a jump is not a way.
    const isWay = span > 0 && span < 1.5 && Math.hypot(this.x(next) - this.x(index), this.y(next) - this.y(index)) <= 1;
    return [index, next, isWay ? (time - this.times[index]!) / span : 0];
  }

  /** Pose at a time, between two samples; null before the first one. */
  at(time: number): Pose | null {
    const found = this.around(time);
    if (found === null) return null;
    const [index, next, share] = found;
    const pose = { ...this.sample(index), time };
    pose.x += share * (this.x(next) - pose.x);
    pose.y += share * (this.y(next) - pose.y);
    pose.yaw += share * wrapped(this.yaw(next) - pose.yaw);
    return pose;
  }

  /** Position and quaternion (x, y, z, w) at a time, between two samples; null before the first one. */
  spatial(time: number): Spatial | null {
    const found = this.around(time);
    if (found === null) return null;
    const [index, next, share] = found;
    const value = (field: number, sample: number) => this.columns[field]![sample]! * this.step;
    const rotations = [index, next].map((sample) => [3, 4, 5, 6].map((field) => value(field, sample)));
    const [from, to] = rotations as [number[], number[]];
    const sign = from.reduce((sum, part, at) => sum + part * to[at]!, 0) < 0 ? -1 : 1; // the shorter way
    const mixed = from.map((part, at) => part + share * (sign * to[at]! - part));
    const length = Math.hypot(...mixed) || 1;
    const place = [0, 1, 2].map((field) => value(field, index) + share * (value(field, next) - value(field, index)));
    return [...place, ...mixed.map((part) => part / length)];
  }

  /** Shapes of the entity at a time, in its own frame: links of robots move. */
  shapes(time: number): Shape[] {
    const shapes = this.scene?.shapes ?? [];
    if (this.links.size === 0) return shapes;
    const moves = new Map<string, Spatial>();
    for (const [link, track] of this.links) {
      const first = this.scene?.links?.[link];
      const now = track.spatial(time);
      if (first && now) moves.set(link, composed(now, inverse(first)));
    }
    return shapes.map((shape) => {
      const move = moves.get(shape.link ?? "");
      return move === undefined ? shape : { ...shape, pose: [...composed(move, shape.pose)] };
    });
  }

  sample(index: number): Pose {
    const z = this.z(index);
    const turn = this.columns[12]![index]! * this.step;
    const time = this.times[index]!;
    return { time, x: this.x(index), y: this.y(index), z, yaw: this.yaw(index), speed: this.speed(index), turn };
  }
}

export class Tracks {
  readonly tracks: Track[] = [];
  readonly believed: (Track | null)[] = [];
  private readonly links: Track[] = [];
  private readonly scans = new Scans();
  private pathTimes = new Float64Array(0);
  private pathEntities = new Int32Array(0);
  private pathEnds = new Int32Array(0);
  private pathValues = new Int32Array(0);
  private step = 1;

  /**
   * Add what is new.
   *
   * @param meta Everything so far.
   * @param more What is new in it.
   */
  append(meta: Meta, more: Partial<Meta>, columns: Columns): void {
    this.step = meta.step;
    const scenes = new Map((meta.scene?.entities ?? []).map((entity) => [entity.name, entity]));
    for (const { name } of more.entities ?? []) {
      this.tracks.push(new Track(name, null, this.step));
      this.believed.push(null);
    }
    this.tracks.forEach((track, index) => {
      // All robots are in a scene; what comes later is an object.
      track.scene =
        scenes.get(track.name) ?? track.scene ?? (scenes.size > 0 ? { name: track.name, kind: "object" } : null);
      track.append(columns, `track.${index}`);
      if (!columns.has(`believed.${index}.t`)) return;
      const believed = (this.believed[index] ??= new Track(track.name, null, this.step));
      believed.append(columns, `believed.${index}`);
    });
    this.appendLinks(more.links ?? [], columns);
    this.scans.append(columns, more.beams ?? []);
    this.pathTimes = grown(this.pathTimes, columns.reals("paths.t"));
    this.pathEntities = grown(this.pathEntities, columns.integers("paths.entity"));
    this.pathEnds = grown(this.pathEnds, columns.integers("paths.end"));
    this.pathValues = grown(this.pathValues, columns.integers("paths.value"));
  }

  private appendLinks(more: [robot: string, link: string][], columns: Columns): void {
    for (const [robot, link] of more) {
      const track = new Track(link, null, this.step);
      this.links.push(track);
      this.tracks.find((each) => each.name === robot)?.links.set(link, track);
    }
    this.links.forEach((track, index) => track.append(columns, `link.${index}`));
  }

  get isEmpty(): boolean {
    return this.tracks.every((track) => track.isEmpty);
  }

  /** Hits of the latest scan of an entity, as x, y and z in the map [m]. */
  hits(entity: number, time: number): [number, number, number][] {
    return this.scans.hits(entity, time, this.step, (then) => this.tracks[entity]?.at(then) ?? null);
  }

  /** Points of the path that a robot follows at a time. */
  path(entity: number, time: number): [number, number][] {
    for (let index = after(this.pathTimes, time + 1e-9) - 1; index >= 0; index--) {
      if (this.pathEntities[index] !== entity) continue;
      const points: [number, number][] = [];
      for (let at = index > 0 ? this.pathEnds[index - 1]! : 0; at + 1 < this.pathEnds[index]!; at += 2) {
        points.push([this.pathValues[at]! * this.step, this.pathValues[at + 1]! * this.step]);
      }
      return points;
    }
    return [];
  }
}

export function wrapped(angle: number): number {
  return angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
}
