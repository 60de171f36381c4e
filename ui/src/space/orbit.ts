// Camera that turns around a point, by pointer and keyboard.
import { PerspectiveCamera, Vector3 } from "three";
import type { Extent } from "../draw/world";

const FIELD = 45; // [degrees] of view, upright
const LOWEST = 0.02; // [rad] above the ground
const HIGHEST = Math.PI / 2 - 0.01;

export class Orbit {
  readonly camera = new PerspectiveCamera(FIELD, 1, 0.05, 1000);
  private target = new Vector3();
  private distance = 10; // [m]
  private azimuth = -Math.PI / 2; // [rad] of the camera, seen from the target
  private elevation = 0.9; // [rad]

  constructor() {
    this.camera.up.set(0, 0, 1);
  }

  /** Show an extent up to a height [m] in full, from the south and above. */
  fit([x0, y0, x1, y1]: Extent, height: number): void {
    this.target.set((x0 + x1) / 2, (y0 + y1) / 2, height / 3);
    const share = Math.tan((FIELD * Math.PI) / 360);
    this.distance = Math.max((y1 - y0) / 2 / share, (x1 - x0) / 2 / share / this.camera.aspect, 1) * 1.1 + height / 2;
    [this.azimuth, this.elevation] = [-Math.PI / 2, 0.9];
    this.place();
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(height, 1);
    this.place();
  }

  /** Turn around the target [rad]. */
  turn(azimuth: number, elevation: number): void {
    this.azimuth += azimuth;
    this.elevation = Math.min(HIGHEST, Math.max(LOWEST, this.elevation + elevation));
    this.place();
  }

  /** Move the target over the ground, in pixels of a picture with a height. */
  shift(right: number, up: number, height: number): void {
    const scale = (2 * this.distance * Math.tan((FIELD * Math.PI) / 360)) / Math.max(height, 1);
    const [cos, sin] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    this.target.x += (-sin * right - cos * up) * scale;
    this.target.y += (cos * right - sin * up) * scale;
    this.place();
  }

  zoom(factor: number): void {
    this.distance = Math.min(2000, Math.max(0.2, this.distance / factor));
    this.place();
  }

  private place(): void {
    const { camera, target, distance } = this;
    const level = distance * Math.cos(this.elevation);
    camera.position.set(
      target.x + level * Math.cos(this.azimuth),
      target.y + level * Math.sin(this.azimuth),
      target.z + distance * Math.sin(this.elevation),
    );
    camera.near = distance / 100;
    camera.far = distance * 20;
    camera.lookAt(target);
    camera.updateProjectionMatrix();
  }
}
