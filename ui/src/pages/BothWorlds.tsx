// The paths of two runs in one picture.
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import type { ServedRun } from "../data/served";
import { onThemeChange, prepare, theme, type Theme } from "../draw/theme";
import { drawEntity, drawStill, drawWay, type Extent, extentOf, fit, mapPicture, type View } from "../draw/world";
import { after } from "../data/unpack";
import { useCell } from "../state";
import { seconds } from "../text";

const NEAR = 40; // [px] within which both poses of a robot share a name
const STEPS = 10_000; // of the slider
const WIDTHS = [4, 2]; // [px] of the ways of A and B: B is thinner and dashed, so that both are visible

interface Props {
  first: ServedRun;
  second: ServedRun;
  /** Time of the first difference [s]. */
  at: number | null;
}

export function BothWorlds({ first, second, at }: Props) {
  const [a, b] = [useCell(first.model), useCell(second.model)];
  if (a === null || b === null) return null;
  if (a.tracks.isEmpty && b.tracks.isEmpty) return null;
  return <Picture a={a} b={b} at={at} />;
}

function Picture({ a, b, at }: { a: RunModel; b: RunModel; at: number | null }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [size, setSize] = useState<[number, number]>([0, 0]);
  const [map, setMap] = useState<HTMLCanvasElement | null>(null);
  const [chosen, setTime] = useState<number | null>(null);
  const end = Math.max(a.end, b.end) || 1;
  const time = chosen ?? at ?? end;
  const [revisionA, revisionB] = [useCell(a.revision), useCell(b.revision)];
  useLayoutEffect(() => {
    const box = canvas.current!.parentElement!;
    const observer = new ResizeObserver(() => setSize([box.clientWidth, box.clientHeight]));
    observer.observe(box);
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    const read = () => {
      if (a.meta.scene?.map) void mapPicture(a.meta.scene.map, theme()).then(setMap);
    };
    read();
    return onThemeChange(read);
  }, [a, a.meta.scene]);
  useEffect(() => {
    if (size[0] === 0) return;
    const draw = () => {
      const colours = theme();
      const view = fit(size[0], size[1], around(extentOf(a), extentOf(b)));
      const context = prepare(canvas.current!, size[0], size[1]);
      context.font = colours.font;
      drawStill(context, a, view, map, colours);
      context.textBaseline = "middle";
      drawRun(context, view, a, 0, b, time, colours);
      drawRun(context, view, b, 1, a, time, colours);
    };
    draw();
    return onThemeChange(draw);
  }, [a, b, size, map, time, revisionA, revisionB]);
  return (
    <section class="panel world both" aria-label="Paths of both runs">
      <div class="head">
        <h2>Both paths</h2>
        <span class="count">
          <span class="line-a" aria-hidden="true" /> A (wide) <span class="line-b" aria-hidden="true" /> B (dashed)
        </span>
      </div>
      <div class="picture">
        <canvas ref={canvas} role="img" aria-label={`World from above with the paths of both runs until ${seconds(time)}`} />
      </div>
      <div class="tools">
        <input
          type="range"
          aria-label="Time of both runs"
          aria-valuetext={seconds(time)}
          min={0}
          max={STEPS}
          value={Math.round((time / end) * STEPS)}
          onInput={(event) => setTime((Number(event.currentTarget.value) / STEPS) * end)}
        />
        <span class="number">{seconds(time)}</span>
        {at !== null && (
          <button type="button" onClick={() => setTime(at)}>
            First difference
          </button>
        )}
      </div>
    </section>
  );
}

function around([ax0, ay0, ax1, ay1]: Extent, [bx0, by0, bx1, by1]: Extent): Extent {
  return [Math.min(ax0, bx0), Math.min(ay0, by0), Math.max(ax1, bx1), Math.max(ay1, by1)];
}

function drawRun(
  context: CanvasRenderingContext2D,
  view: View,
  run: RunModel,
  side: 0 | 1,
  other: RunModel,
  time: number,
  colours: Theme,
): void {
  const colour = colours.entities[side]!;
  for (const track of run.tracks.tracks) {
    context.strokeStyle = colour;
    context.lineWidth = WIDTHS[side]!;
    context.globalAlpha = 0.5;
    context.setLineDash(side === 1 ? [7, 5] : []);
    drawWay(context, view, track, 0, track.times.length);
    context.globalAlpha = 1;
    drawWay(context, view, track, 0, after(track.times, time));
    context.setLineDash([]);
    const pose = track.at(time);
    if (pose === null) continue;
    const twin = other.tracks.tracks.find((each) => each.name === track.name)?.at(time) ?? null;
    const isNear = twin !== null && Math.hypot(twin.x - pose.x, twin.y - pose.y) * view.scale < NEAR;
    const name = isNear ? (side === 0 ? "" : `${track.name} A, B`) : `${track.name} ${"AB"[side]}`;
    drawEntity(context, view, track, pose, colour, colours, name);
  }
}
