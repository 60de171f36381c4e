// The world from above, at the time that the page shows.
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import { after } from "../data/unpack";
import { onThemeChange, prepare, theme } from "../draw/theme";
import { drawEntity, drawStill, drawWay, extentOf, fit, mapPicture, screen, type View } from "../draw/world";
import { hasSpace } from "../space/loading";
import { useCell, useRevision } from "../state";
import { clip, fixed, plain, plural } from "../text";
import type { ViewProps } from "./RunViews";
import { Space, type SpaceControl } from "./Space";

const MOST_LISTED = 40;
const HIT = 3; // [pixels] of a hit of a laser scan
const TRAILS = 4_000; // latest samples of all ways, drawn strongly

export function World({ run, state }: ViewProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const still = useRef<HTMLCanvasElement>(null);
  const space = useRef<SpaceControl>(null);
  const [isSpace, setIsSpace] = useState(false);
  const drawn = useRef<number[]>([]); // samples of each track in the lower picture
  const [size, setSize] = useState<[number, number]>([0, 0]);
  const [view, setView] = useState<View | null>(null);
  const [map, setMap] = useState<HTMLCanvasElement | null>(null);
  const [themeCount, setThemeCount] = useState(0);
  const revision = useRevision(run);
  const { scene } = run.meta;
  const extent = useMemo(() => extentOf(run), [run, scene, scene?.extent ? 0 : revision]);

  useLayoutEffect(() => {
    const box = canvas.current!.parentElement!;
    const observer = new ResizeObserver(() => setSize([box.clientWidth, box.clientHeight]));
    observer.observe(box);
    return () => observer.disconnect();
  }, []);
  useEffect(() => onThemeChange(() => setThemeCount((count) => count + 1)), []);
  useEffect(() => {
    if (scene?.map) void mapPicture(scene.map, theme()).then(setMap);
  }, [scene, themeCount]);
  const shown = useMemo(
    () => (view === null ? fit(size[0], size[1], extent) : { ...view, width: size[0], height: size[1] }),
    [view, size, extent],
  );
  useEffect(() => {
    if (size[0] === 0) return;
    const colours = theme();
    const context = prepare(still.current!, size[0], size[1]);
    context.font = colours.font;
    drawStill(context, run, shown, map, colours);
    drawn.current = [];
  }, [run, scene, shown, map, themeCount]);
  useEffect(() => {
    if (size[0] === 0) return;
    const context = still.current!.getContext("2d")!;
    const colours = theme();
    run.tracks.tracks.forEach((track, index) => {
      context.globalAlpha = 0.35;
      context.lineWidth = 1.5;
      context.strokeStyle = colours.entities[index % colours.entities.length]!;
      drawWay(context, shown, track, Math.max((drawn.current[index] ?? 0) - 1, 0), track.times.length);
      context.globalAlpha = 1;
      drawn.current[index] = track.times.length;
    });
    const draw = () => drawMoving(canvas.current!, run, shown, state.time.value);
    draw();
    return state.time.subscribe(draw);
  }, [run, scene, state, shown, map, themeCount, revision]);

  const zoom = (factor: number) => {
    if (isSpace) space.current?.zoom(factor);
    else setView({ ...shown, scale: shown.scale * factor });
  };
  const showAll = () => {
    if (isSpace) space.current?.fit();
    else setView(null);
  };
  const shift = (x: number, y: number) =>
    setView({ ...shown, x: shown.x + x / shown.scale, y: shown.y + y / shown.scale });
  const onKey = (event: KeyboardEvent) => {
    const keys: Record<string, () => void> = {
      ArrowLeft: () => shift(-40, 0),
      ArrowRight: () => shift(40, 0),
      ArrowUp: () => shift(0, 40),
      ArrowDown: () => shift(0, -40),
      "+": () => zoom(1.4),
      "-": () => zoom(1 / 1.4),
      "0": showAll,
    };
    const action = keys[event.key];
    if (action === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  };
  return (
    <section class="panel world" aria-label="World from above">
      <div class="head">
        <h2>World</h2>
        <span class="count">{clip(plain(run.meta.scene?.world ?? ""), 60)}</span>
        <div class="buttons">
          <button type="button" aria-label="Zoom into the world" onClick={() => zoom(1.4)}>
            +
          </button>
          <button type="button" aria-label="Zoom out of the world" onClick={() => zoom(1 / 1.4)}>
            −
          </button>
          <button type="button" onClick={showAll}>
            Fit
          </button>
          {hasSpace() && (
            <button type="button" aria-pressed={isSpace} onClick={() => setIsSpace(!isSpace)}>
              3D
            </button>
          )}
        </div>
      </div>
      <div class="picture">
        <canvas ref={still} aria-hidden="true" />
        {isSpace && <Space run={run} state={state} map={map} control={space} key={themeCount} />}
        <canvas
          ref={canvas}
          hidden={isSpace}
          tabIndex={0}
          role="img"
          aria-label="World from above. Arrows move the picture, + and − zoom, 0 fits. The poses are listed below."
          onKeyDown={onKey}
          onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
          onPointerMove={(event) => event.buttons === 1 && shift(-event.movementX, event.movementY)}
          onWheel={(event) => {
            if (!event.ctrlKey) return;
            event.preventDefault();
            zoom(event.deltaY > 0 ? 0.85 : 1.18);
          }}
        />
      </div>
      <Poses run={run} state={state} />
    </section>
  );
}

function drawMoving(canvas: HTMLCanvasElement, run: RunModel, view: View, time: number): void {
  const colours = theme();
  const context = prepare(canvas, view.width, view.height);
  context.font = colours.font;
  context.textBaseline = "middle";
  const trail = Math.max(Math.floor(TRAILS / Math.max(run.tracks.tracks.length, 1)), 20);
  run.tracks.tracks.forEach((track, index) => {
    const pose = track.at(time);
    if (pose === null) return;
    const colour = colours.entities[index % colours.entities.length]!;
    context.strokeStyle = colour;
    context.lineWidth = 3;
    const until = after(track.times, time);
    drawWay(context, view, track, Math.max(until - trail, 0), until);
    context.lineWidth = 2;
    context.setLineDash([6, 5]);
    context.beginPath();
    run.tracks.path(index, time).forEach(([x, y], at) => context[at === 0 ? "moveTo" : "lineTo"](...screen(view, x, y)));
    context.stroke();
    context.setLineDash([]);
    context.fillStyle = colours.cursor;
    for (const [x, y] of run.tracks.hits(index, time)) context.fillRect(...topLeft(screen(view, x, y)), HIT, HIT);
    const believed = run.tracks.believed[index]?.at(time);
    if (believed) {
      const [x, y] = screen(view, believed.x, believed.y);
      context.strokeStyle = colours.text;
      context.lineWidth = 1.5;
      context.strokeRect(x - 5, y - 5, 10, 10);
    }
  });
  run.tracks.tracks.forEach((track, index) => {
    const pose = track.at(time);
    if (pose !== null) drawEntity(context, view, track, pose, colours.entities[index % colours.entities.length]!, colours);
  });
}

function topLeft([x, y]: [number, number]): [number, number] {
  return [x - HIT / 2, y - HIT / 2];
}

/** The poses as a table: what the picture shows, for everyone. */
function Poses({ run, state }: { run: RunModel; state: ViewProps["state"] }) {
  const time = useCell(state.time);
  const tracks = run.tracks.tracks.slice(0, MOST_LISTED);
  if (run.tracks.isEmpty) return <p class="empty">The trace has no poses.</p>;
  return (
    <div class="poses scrolls" tabIndex={0} role="region" aria-label="Poses">
      <table>
        <thead>
          <tr>
            <th scope="col">name</th>
            <th scope="col">x [m]</th>
            <th scope="col">y [m]</th>
            <th scope="col">yaw [°]</th>
            <th scope="col">speed [m/s]</th>
          </tr>
        </thead>
        <tbody>
          {tracks.map((track, index) => {
            const pose = track.at(time);
            return (
              <tr key={track.name}>
                <th scope="row">
                  <span class={`dot entity-${(index % 7) + 1}`} aria-hidden="true" /> <bdi>{clip(plain(track.name), 60)}</bdi>
                  {track.scene?.real === true && <span class="real"> real</span>}
                  {track.isByOdometry(time) && (
                    <span class="odometry" title="The place of the robot in the map is unknown: its way is shown from the origin.">
                      {" "}
                      by odometry
                    </span>
                  )}
                </th>
                {pose === null ? (
                  <td colSpan={4}>not there yet</td>
                ) : (
                  <>
                    <td>{fixed(pose.x, 2)}</td>
                    <td>{fixed(pose.y, 2)}</td>
                    <td>{fixed((pose.yaw * 180) / Math.PI, 0)}</td>
                    <td>{fixed(pose.speed, 2)}</td>
                  </>
                )}
              </tr>
            );
          })}
        </tbody>
      </table>
      {run.tracks.tracks.length > MOST_LISTED && (
        <p>{plural(run.tracks.tracks.length - MOST_LISTED, "further entity", "further entities")}</p>
      )}
    </div>
  );
}
