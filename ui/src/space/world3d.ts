// The world in three dimensions. Built into a file of its own, which pages load on demand.
import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  CanvasTexture,
  Color,
  DirectionalLight,
  GridHelper,
  Group,
  Line,
  LineBasicMaterial,
  LineDashedMaterial,
  LineSegments,
  type Material,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  type Object3D,
  PlaneGeometry,
  Points,
  PointsMaterial,
  Scene,
  type Sprite,
  SRGBColorSpace,
  WebGLRenderer,
} from "three";
import type { RunModel } from "../data/model";
import type { Track } from "../data/tracks";
import { after } from "../data/unpack";
import { type Theme, theme } from "../draw/theme";
import { extentOf, isFlat } from "../draw/world";
import { bodyOf, entityBody, place } from "./bodies";
import { dispose, labelOf } from "./labels";
import type { Picture } from "./loading";
import { Orbit } from "./orbit";

const ABOVE = 0.02; // [m] of lines above the ground
const TURN = 0.008; // [rad/pixel]
const HIGHEST = 3; // [m] of entities that are shown in full
const JUMP = 2; // [m] between two samples that are not a way

interface Shown {
  track: Track;
  body: Group;
  label: Sprite | null;
  text: string; // of the label
  way: LineSegments;
  samples: number; // in the way
  plan: Line;
}

/** A picture of a run that can be turned. */
class World3D implements Picture {
  private readonly orbit = new Orbit();
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly shown: Shown[] = [];
  private readonly hits: Points;
  private readonly colours = theme();
  private size: [number, number] = [1, 1];

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly run: RunModel,
    map: HTMLCanvasElement | null,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(devicePixelRatio || 1);
    const { colours } = this;
    this.scene.background = new Color(colours.unknown);
    const sun = new DirectionalLight(0xffffff, 2);
    sun.position.set(3, -5, 10);
    this.scene.add(new AmbientLight(0xffffff, 1.6), sun);
    this.addGround(map, colours);
    this.scene.add(bodyOf((run.meta.scene?.shapes ?? []).filter((shape) => !isFlat(shape)), colours.wall));
    run.tracks.tracks.forEach((track, index) => this.addTrack(track, colours.entities[index % colours.entities.length]!));
    this.hits = new Points(new BufferGeometry(), new PointsMaterial({ color: colours.cursor, size: 4, sizeAttenuation: false }));
    this.hits.frustumCulled = false;
    this.scene.add(this.hits);
    this.fit();
  }

  resize(width: number, height: number): void {
    if (width === this.size[0] && height === this.size[1]) return;
    const isFirst = this.size[0] === 1;
    this.size = [width, height];
    this.renderer.setSize(width, height, false);
    this.orbit.resize(width, height);
    if (isFirst) this.fit();
  }

  turn(right: number, up: number): void {
    this.orbit.turn(-right * TURN, up * TURN);
  }

  shift(right: number, up: number): void {
    this.orbit.shift(right, up, this.size[1]);
  }

  zoom(factor: number): void {
    this.orbit.zoom(factor);
  }

  fit(): void {
    const heights = this.run.tracks.tracks.map((track) => track.scene?.height ?? 0);
    this.orbit.fit(extentOf(this.run), Math.min(Math.max(0, ...heights), HIGHEST));
  }

  /** Draw the world at a time of the run [s]. */
  show(time: number): void {
    this.shown.forEach((shown, index) => {
      const { track, body, way, plan } = shown;
      const pose = track.spatial(time);
      body.visible = pose !== null;
      this.rename(shown, track.labelAt(time));
      if (pose !== null) {
        place(body, pose);
        if (track.links.size > 0) track.shapes(time).forEach((shape, at) => place(body.children[at]!, shape.pose));
      }
      if (shown.samples < track.times.length) {
        way.geometry.setAttribute("position", new BufferAttribute(wayOf(track), 3));
        shown.samples = track.times.length;
      }
      way.geometry.setDrawRange(0, 2 * Math.max(0, after(track.times, time) - 1));
      const points = this.run.tracks.path(index, time).map(([x, y]) => [x, y, ABOVE]);
      replacePoints(plan.geometry, points.flat());
      plan.computeLineDistances();
    });
    const hits = this.shown.flatMap((_, index) => this.run.tracks.hits(index, time)).flat();
    replacePoints(this.hits.geometry, hits);
    this.renderer.render(this.scene, this.orbit.camera);
    this.canvas.dataset["hits"] = String(hits.length / 3);
    this.canvas.dataset["labels"] = this.shown.filter(({ body }) => body.visible).map(({ text }) => text).join("\n");
    this.canvas.dataset["triangles"] = String(this.renderer.info.render.triangles);
  }

  /** Free the memory of the graphics. */
  dispose(): void {
    this.scene.traverse((object: Object3D) => {
      const { geometry, material } = object as Partial<Mesh>;
      geometry?.dispose();
      for (const each of [material ?? []].flat() as Material[]) {
        (each as MeshBasicMaterial).map?.dispose();
        each.dispose();
      }
    });
    this.renderer.dispose();
  }

  private addGround(map: HTMLCanvasElement | null, colours: Theme): void {
    const [x0, y0, x1, y1] = extentOf(this.run);
    const given = this.run.meta.scene?.map;
    if (map !== null && given) {
      const texture = new CanvasTexture(map);
      texture.colorSpace = SRGBColorSpace;
      texture.magFilter = NearestFilter;
      const [width, height] = [given.width * given.resolution, given.height * given.resolution];
      const ground = new Mesh(new PlaneGeometry(width, height).translate(width / 2, height / 2, 0), new MeshBasicMaterial({ map: texture }));
      ground.position.set(given.origin[0], given.origin[1], 0);
      ground.rotation.z = given.origin[2];
      this.scene.add(ground);
      return;
    }
    const span = Math.ceil(Math.max(x1 - x0, y1 - y0)) + 2;
    const ground = new Mesh(new PlaneGeometry(span, span), new MeshBasicMaterial({ color: colours.floor }));
    const grid = new GridHelper(span, span, colours.line, colours.line).rotateX(Math.PI / 2);
    const place = new Group().add(ground, grid);
    grid.position.z = ABOVE / 4;
    place.position.set(Math.round((x0 + x1) / 2), Math.round((y0 + y1) / 2), -ABOVE / 4);
    this.scene.add(place);
  }

  /** Change the label of a body, which is its last part. */
  private rename(shown: Shown, text: string): void {
    if (text === shown.text) return;
    if (shown.label !== null) {
      shown.body.remove(shown.label);
      dispose(shown.label);
    }
    shown.text = text;
    shown.label = labelOf(text, this.colours);
    shown.label.position.z = (shown.track.scene?.height || 0.3) + 0.15;
    shown.body.add(shown.label);
  }

  private addTrack(track: Track, colour: string): void {
    const body = entityBody(track.scene, colour);
    const way = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: colour }));
    const plan = new Line(new BufferGeometry(), new LineDashedMaterial({ color: colour, dashSize: 0.12, gapSize: 0.1 }));
    way.frustumCulled = plan.frustumCulled = false;
    this.scene.add(body, way, plan);
    this.shown.push({ track, body, label: null, text: "", way, samples: 0, plan });
  }
}

/** Segments of a way: x, y and z of their ends. */
function wayOf(track: Track): Float32Array {
  const count = track.times.length;
  const points = new Float32Array(Math.max(0, count - 1) * 6);
  for (let index = 1; index < count; index++) {
    const [x, y] = [track.x(index), track.y(index)];
    const isJump = Math.hypot(x - track.x(index - 1), y - track.y(index - 1)) > JUMP;
    const [fromX, fromY] = isJump ? [x, y] : [track.x(index - 1), track.y(index - 1)];
    points.set([fromX, fromY, track.z(index - 1) + ABOVE, x, y, track.z(index) + ABOVE], (index - 1) * 6);
  }
  return points;
}

function replacePoints(geometry: BufferGeometry, points: number[]): void {
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
}

globalThis.seoroWorld3D = (canvas, run, map) => new World3D(canvas, run, map);
