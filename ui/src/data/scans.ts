// Laser scans of robots over time.
import type { Pose } from "./tracks";
import { after, type Columns, grown } from "./unpack";

const KEPT = 2; // [s] for which a scan is shown

export class Scans {
  private times = new Float64Array(0);
  private entities = new Int32Array(0);
  private ends = new Int32Array(0);
  private ranges = new Int32Array(0); // in steps; negative without a hit
  private readonly beams: number[][] = [];

  /** Add what is new; `beams` has a pose (x, y, z, quaternion), the first bearing and the step of each new scan. */
  append(columns: Columns, beams: number[][]): void {
    this.times = grown(this.times, columns.reals("scans.t"));
    this.entities = grown(this.entities, columns.integers("scans.entity"));
    this.ends = grown(this.ends, columns.integers("scans.end"));
    this.ranges = grown(this.ranges, columns.integers("scans.value"));
    this.beams.push(...beams);
  }

  /**
   * Hits of the latest scan of an entity, as x, y and z in the map [m].
   *
   * @param step Size of a step [m].
   * @param poseAt Pose of the entity at a time.
   */
  hits(entity: number, time: number, step: number, poseAt: (time: number) => Pose | null): [number, number, number][] {
    for (let index = after(this.times, time + 1e-9) - 1; index >= 0; index--) {
      if (time - this.times[index]! > KEPT) break;
      if (this.entities[index] === entity) return this.placed(index, step, poseAt(this.times[index]!));
    }
    return [];
  }

  private placed(index: number, step: number, pose: Pose | null): [number, number, number][] {
    const beam = this.beams[index];
    if (pose === null || beam === undefined) return [];
    const [px = 0, py = 0, pz = 0, , , qz = 0, qw = 1, first = 0, angle = 0] = beam;
    const turned = pose.yaw + 2 * Math.atan2(qz, qw);
    const [cos, sin] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
    const [x, y] = [pose.x + cos * px - sin * py, pose.y + sin * px + cos * py];
    const found: [number, number, number][] = [];
    const start = index > 0 ? this.ends[index - 1]! : 0;
    for (let at = start; at < this.ends[index]!; at++) {
      if (this.ranges[at]! < 0) continue;
      const [range, bearing] = [this.ranges[at]! * step, turned + first + (at - start) * angle];
      found.push([x + range * Math.cos(bearing), y + range * Math.sin(bearing), pose.z + pz]);
    }
    return found;
  }
}
