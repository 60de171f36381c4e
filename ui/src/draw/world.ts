// The world from above: map, walls, ways, and everything that moves.
import type { RunModel } from "../data/model";
import { fromBase64, inflate } from "../data/unpack";
import type { GridMap, Shape } from "../data/types";
import type { Spatial } from "../data/frames3";
import type { Pose, Track } from "../data/tracks";
import { clip, plain } from "../text";
import { outlineOf } from "./outlines";
import { niceStep, type Theme } from "./theme";

/** From metres of the world to pixels. */
export interface View {
  width: number;
  height: number;
  /** Pixels of a metre. */
  scale: number;
  x: number;
  y: number;
}

export type Extent = [x0: number, y0: number, x1: number, y1: number];

export function screen(view: View, x: number, y: number): [number, number] {
  return [view.width / 2 + (x - view.x) * view.scale, view.height / 2 - (y - view.y) * view.scale];
}

/** View that shows an extent in full. */
export function fit(width: number, height: number, [x0, y0, x1, y1]: Extent): View {
  const scale = Math.min((width - 24) / Math.max(x1 - x0, 0.5), (height - 24) / Math.max(y1 - y0, 0.5));
  return { width, height, scale: Math.max(scale, 1e-3), x: (x0 + x1) / 2, y: (y0 + y1) / 2 };
}

/** Extent of the scene, or of everything that moved. */
export function extentOf(run: RunModel): Extent {
  const given = run.meta.scene?.extent;
  if (Array.isArray(given) && given.length === 4 && given.every(Number.isFinite)) return given;
  let [x0, y0, x1, y1]: Extent = [Infinity, Infinity, -Infinity, -Infinity];
  for (const track of run.tracks.tracks) {
    for (let index = 0; index < track.times.length; index++) {
      const [x, y] = [track.x(index), track.y(index)];
      [x0, y0, x1, y1] = [Math.min(x0, x), Math.min(y0, y), Math.max(x1, x), Math.max(y1, y)];
    }
  }
  return x0 <= x1 ? [x0 - 1, y0 - 1, x1 + 1, y1 + 1] : [-1, -1, 1, 1];
}

/** Picture of a map; null if its data is invalid. */
export async function mapPicture(map: GridMap, colours: Theme): Promise<HTMLCanvasElement | null> {
  const size = map.width * map.height;
  if (!(size > 0 && size <= 64_000_000)) return null;
  const cells = await inflate(fromBase64(map.data)).catch(() => null);
  if (cells === null || cells.length < size) return null;
  const canvas = document.createElement("canvas");
  canvas.width = map.width;
  canvas.height = map.height;
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(map.width, map.height);
  const pixels = new Uint32Array(image.data.buffer);
  const [free, wall, unknown] = [colours.floor, colours.wall, colours.unknown].map(packedColour) as [number, number, number];
  for (let row = 0; row < map.height; row++) {
    const from = (map.height - 1 - row) * map.width; // pictures begin at the top
    for (let column = 0; column < map.width; column++) {
      const cell = cells[from + column]!;
      pixels[row * map.width + column] = cell === 255 ? unknown : cell >= 50 ? wall : free;
    }
  }
  context.putImageData(image, 0, 0);
  return canvas;
}

function packedColour(hex: string): number {
  const value = Number.parseInt(hex.slice(1, 7), 16) || 0;
  return (0xff << 24) | ((value & 0xff) << 16) | (value & 0xff00) | (value >> 16);
}

/** Draw what does not move. */
export function drawStill(
  context: CanvasRenderingContext2D,
  run: RunModel,
  view: View,
  map: HTMLCanvasElement | null,
  colours: Theme,
): void {
  context.fillStyle = map === null ? colours.floor : colours.unknown;
  context.fillRect(0, 0, view.width, view.height);
  const scene = run.meta.scene;
  if (map !== null && scene?.map) drawMap(context, view, scene.map, map);
  drawGrid(context, view, colours);
  for (const shape of (scene?.shapes ?? []).filter((found) => !isFlat(found))) drawShape(context, view, shape, null, colours.wall, colours);
  for (const place of scene?.places ?? []) {
    const [x, y] = screen(view, place.pose[0], place.pose[1]);
    context.fillStyle = colours.muted;
    context.fillText(clip(plain(place.name), 40), x + 6, y);
    context.fillRect(x - 2, y - 2, 4, 4);
  }
}

function drawMap(context: CanvasRenderingContext2D, view: View, map: GridMap, picture: HTMLCanvasElement): void {
  const [x, y] = screen(view, map.origin[0], map.origin[1]);
  context.save();
  context.translate(x, y);
  context.rotate(-map.origin[2]);
  context.imageSmoothingEnabled = false;
  const [width, height] = [map.width * map.resolution * view.scale, map.height * map.resolution * view.scale];
  context.drawImage(picture, 0, -height, width, height);
  context.restore();
}

function drawGrid(context: CanvasRenderingContext2D, view: View, colours: Theme): void {
  const step = Math.max(niceStep(view.width / view.scale, view.width / 70), 0.01);
  context.fillStyle = colours.line;
  context.globalAlpha = 0.6;
  const [left, right] = [view.x - view.width / 2 / view.scale, view.x + view.width / 2 / view.scale];
  const [bottom, top] = [view.y - view.height / 2 / view.scale, view.y + view.height / 2 / view.scale];
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) context.fillRect(screen(view, x, 0)[0], 0, 1, view.height);
  for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) context.fillRect(0, screen(view, 0, y)[1], view.width, 1);
  context.globalAlpha = 1;
  // A bar of the scale, since coordinates matter less than lengths.
  const [x, y] = [12, view.height - 12];
  context.fillStyle = colours.text;
  context.fillRect(x, y, step * view.scale, 2);
  context.fillText(`${Number(step.toPrecision(2))} m`, x, y - 8);
}

/** Whether a shape is part of the ground, which would hide the map. */
export function isFlat(shape: Shape): boolean {
  return shape.kind === "box" && (shape.pose[2] ?? 0) + (shape.size[2] ?? 1) / 2 <= 0.02;
}

/** Draw a shape; its pose is relative to that of its entity. */
function drawShape(
  context: CanvasRenderingContext2D,
  view: View,
  shape: Shape,
  around: Spatial | null,
  fallback: string,
  colours: Theme,
): void {
  const outline = outlineOf(shape, around);
  if (outline.length === 0) return;
  context.fillStyle = shape.color && /^#[0-9a-f]{6}/i.test(shape.color) ? shape.color.slice(0, 7) : fallback;
  context.strokeStyle = colours.text;
  context.lineWidth = 0.5;
  context.beginPath();
  outline.forEach(([x, y], index) => context[index === 0 ? "moveTo" : "lineTo"](...screen(view, x, y)));
  context.closePath();
  context.fill();
  context.stroke();
}

/** Draw the way of an entity from one sample to another, without points that share a pixel. */
export function drawWay(context: CanvasRenderingContext2D, view: View, track: Track, from: number, to: number): void {
  let [lastX, lastY] = [Infinity, Infinity];
  context.beginPath();
  for (let index = from; index < to; index++) {
    const [x, y] = screen(view, track.x(index), track.y(index));
    if (index > from && Math.abs(x - lastX) < 1 && Math.abs(y - lastY) < 1) continue;
    // A jump is not a way: entities may be placed elsewhere.
    if (index === from || Math.hypot(x - lastX, y - lastY) > 2 * view.scale) context.moveTo(x, y);
    else context.lineTo(x, y);
    [lastX, lastY] = [x, y];
  }
  context.stroke();
}

/** Draw an entity: its footprint or shapes, its direction and its name. */
export function drawEntity(
  context: CanvasRenderingContext2D,
  view: View,
  track: Track,
  pose: Pose,
  colour: string,
  colours: Theme,
  name = track.name,
): void {
  const { scene } = track;
  const [x, y] = screen(view, pose.x, pose.y);
  const footprint = scene?.footprint ?? [];
  const isRobot = scene === null || scene.kind === undefined || scene.kind === "robot" || scene.kind === "person";
  context.lineWidth = 2;
  context.strokeStyle = colours.surface;
  context.fillStyle = colour;
  const shapes = track.shapes(pose.time);
  const frame = track.spatial(pose.time);
  if ((!isRobot || footprint.length < 3) && shapes.length > 0) {
    for (const shape of shapes) drawShape(context, view, shape, frame, colour, colours);
  } else {
    context.beginPath();
    if (footprint.length >= 3) {
      const [cos, sin] = [Math.cos(pose.yaw), Math.sin(pose.yaw)];
      footprint.forEach(([px, py], index) => {
        const [fx, fy] = screen(view, pose.x + cos * px - sin * py, pose.y + sin * px + cos * py);
        if (index === 0) context.moveTo(fx, fy);
        else context.lineTo(fx, fy);
      });
      context.closePath();
    } else {
      context.arc(x, y, Math.max(6, 0.15 * view.scale), 0, 2 * Math.PI);
    }
    context.fill();
    context.stroke();
    for (const shape of shapes) if (shape.link) drawShape(context, view, shape, frame, colour, colours);
  }
  if (isRobot && (footprint.length >= 3 || shapes.length === 0)) drawDirection(context, x, y, pose.yaw, Math.max(9, 0.22 * view.scale), colours);
  drawName(context, x, y, track.labelAt(pose.time, name), Math.max(9, 0.2 * view.scale), colours);
}

function drawDirection(
  context: CanvasRenderingContext2D,
  x: number,
  y: number,
  yaw: number,
  length: number,
  colours: Theme,
): void {
  const [cos, sin] = [Math.cos(yaw), -Math.sin(yaw)];
  context.fillStyle = colours.surface;
  context.strokeStyle = colours.text;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(x + cos * length, y + sin * length);
  context.lineTo(x - sin * length * 0.35, y + cos * length * 0.35);
  context.lineTo(x + sin * length * 0.35, y - cos * length * 0.35);
  context.closePath();
  context.fill();
  context.stroke();
}

function drawName(
  context: CanvasRenderingContext2D,
  x: number,
  y: number,
  name: string,
  distance: number,
  colours: Theme,
): void {
  const text = clip(plain(name), 40);
  context.lineWidth = 3;
  context.strokeStyle = colours.surface;
  context.strokeText(text, x + distance + 3, y - distance);
  context.fillStyle = colours.text;
  context.fillText(text, x + distance + 3, y - distance);
}
