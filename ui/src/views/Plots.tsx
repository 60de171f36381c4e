// Plots of numbers over time: speeds, variables, numbers of events, errors of localisations.
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { RunModel, Series } from "../data/model";
import { after } from "../data/unpack";
import { drawPlot, frameOf, plotTime, plotX } from "../draw/plot";
import { onThemeChange, theme } from "../draw/theme";
import { useCell, useRevision } from "../state";
import { clip, digits, plain, plural } from "../text";
import type { ViewProps } from "./RunViews";

const SHOWN = 4; // plots at first
const HEIGHT = 130; // [px]
const MOST = 60; // choices

export function Plots({ run, state }: ViewProps) {
  const all = useMemo(() => allSeries(run), [run, useRevision(run)]);
  const [picked, setChosen] = useState<ReadonlySet<string> | null>(null);
  const chosen = picked ?? new Set(all.slice(0, SHOWN).map(keyOf));
  const [filter, setFilter] = useState("");
  if (all.length === 0) return <p class="empty">The run has no numbers over time.</p>;
  const matching = all.filter((series) => series.name.toLowerCase().includes(filter.toLowerCase()));
  const toggle = (series: Series) => {
    const next = new Set(chosen);
    if (!next.delete(keyOf(series))) next.add(keyOf(series));
    setChosen(next);
  };
  return (
    <div class="plots scrolls" tabIndex={0} role="region" aria-label="Plots">
      <details open={all.length > SHOWN}>
        <summary>{plural(all.length, "series", "series")}</summary>
        {all.length > 10 && (
          <label class="search">
            <span class="name">search</span>{" "}
            <input type="search" value={filter} onInput={(event) => setFilter(event.currentTarget.value)} />
          </label>
        )}
        <ul class="choices">
          {matching.slice(0, MOST).map((series) => (
            <li key={keyOf(series)}>
              <label>
                <input type="checkbox" checked={chosen.has(keyOf(series))} onChange={() => toggle(series)} />{" "}
                <bdi>{clip(plain(series.name), 80)}</bdi>
              </label>
            </li>
          ))}
        </ul>
        {matching.length > MOST && <p>{plural(matching.length - MOST, "further one", "further ones")}: search.</p>}
      </details>
      {all
        .filter((series) => chosen.has(keyOf(series)))
        .map((series) => (
          <Plot key={keyOf(series)} run={run} state={state} series={series} />
        ))}
    </div>
  );
}

function keyOf(series: Series): string {
  return `${series.kind} ${series.name}`;
}

function Plot({ run, state, series }: ViewProps & { series: Series }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [width, setWidth] = useState(0);
  const time = useCell(state.time);
  const frame = useMemo(
    () => frameOf(series, run.end, width, HEIGHT),
    [run, series, series.times.length, run.end, width],
  );
  useLayoutEffect(() => {
    const box = canvas.current!.parentElement!;
    const observer = new ResizeObserver(() => setWidth(box.clientWidth));
    observer.observe(box);
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    if (width === 0) return;
    const draw = () => drawPlot(canvas.current!, series, frame, theme());
    draw();
    return onThemeChange(draw);
  }, [series, frame]);
  const at = after(series.times, time + 1e-9) - 1;
  const unit = series.unit === "" ? "" : ` ${series.unit}`;
  return (
    <figure>
      <figcaption>
        <bdi>{clip(plain(series.name), 120)}</bdi>
        {series.unit && ` [${series.unit}]`}
        <span class="value">{at < 0 ? "no value yet" : `${digits(series.values[at]!, 4)}${unit}`}</span>
      </figcaption>
      <div class="plot bars" aria-hidden="true">
        <canvas
          ref={canvas}
          style={{ height: `${HEIGHT}px` }}
          onClick={(event) => state.show(plotTime(frame, event.offsetX))}
        />
        <div class="cursor" style={{ transform: `translateX(${plotX(frame, time)}px)` }} />
      </div>
    </figure>
  );
}

/** Speeds of everything that moves, then the series of the trace. */
function allSeries(run: RunModel): Series[] {
  const speeds = run.tracks.tracks.flatMap((track): Series[] => {
    const values = track.speeds();
    if (!values.some((value) => value > 0.02)) return [];
    return [{ kind: "entity", name: `${track.name}: speed`, unit: "m/s", times: track.times, values }];
  });
  const order = ["entity", "variable", "event"];
  const others = [...run.series].sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
  return [...speeds, ...others];
}
