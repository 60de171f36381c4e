// Plots of numbers over time: speeds, variables, numbers of events, errors of localisations.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import uPlot from "uplot";
import type { RunModel, Series } from "../data/model";
import { after } from "../data/unpack";
import { onThemeChange, theme } from "../draw/theme";
import { useCell } from "../state";
import { clip, digits, plain, plural } from "../text";
import type { ViewProps } from "./App";

const SHOWN = 4; // plots at first
const HEIGHT = 130; // [px]
const MOST = 60; // choices

export function Plots({ run, state }: ViewProps) {
  const all = useMemo(() => allSeries(run), [run]);
  const [chosen, setChosen] = useState<ReadonlySet<number>>(() => new Set(firsts(all)));
  const [filter, setFilter] = useState("");
  if (all.length === 0) return <p class="empty">The run has no numbers over time.</p>;
  const matching = all
    .map((series, index): [Series, number] => [series, index])
    .filter(([series]) => series.name.toLowerCase().includes(filter.toLowerCase()));
  const toggle = (index: number) => {
    const next = new Set(chosen);
    if (!next.delete(index)) next.add(index);
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
          {matching.slice(0, MOST).map(([series, index]) => (
            <li key={index}>
              <label>
                <input type="checkbox" checked={chosen.has(index)} onChange={() => toggle(index)} />{" "}
                <bdi>{clip(plain(series.name), 80)}</bdi>
              </label>
            </li>
          ))}
        </ul>
        {matching.length > MOST && <p>{plural(matching.length - MOST, "further one", "further ones")}: search.</p>}
      </details>
      {all.map((series, index) => chosen.has(index) && <Plot key={index} run={run} state={state} series={series} />)}
    </div>
  );
}

function firsts(all: Series[]): number[] {
  return [...all.keys()].slice(0, SHOWN);
}

function Plot({ run, state, series }: ViewProps & { series: Series }) {
  const box = useRef<HTMLDivElement>(null);
  const time = useCell(state.time);
  useEffect(() => {
    const element = box.current!;
    let plot: uPlot | null = null;
    const make = () => {
      plot?.destroy();
      plot = new uPlot(options(run, state, series, element.clientWidth), [series.times, series.values], element);
    };
    make();
    const observer = new ResizeObserver(() => plot?.setSize({ width: element.clientWidth, height: HEIGHT }));
    observer.observe(element);
    const stops = [state.time.subscribe(() => plot?.redraw(false)), onThemeChange(make)];
    return () => {
      stops.forEach((stop) => stop());
      observer.disconnect();
      plot?.destroy();
    };
  }, [run, state, series]);
  const at = after(series.times, time + 1e-9) - 1;
  const unit = series.unit === "" ? "" : ` ${series.unit}`;
  return (
    <figure>
      <figcaption>
        <bdi>{clip(plain(series.name), 120)}</bdi>
        {series.unit && ` [${series.unit}]`}
        <span class="value">{at < 0 ? "no value yet" : `${digits(series.values[at]!, 4)}${unit}`}</span>
      </figcaption>
      <div ref={box} class="plot" aria-hidden="true" />
    </figure>
  );
}

function options(run: RunModel, state: ViewProps["state"], series: Series, width: number): uPlot.Options {
  const colours = theme();
  const axis = { stroke: colours.muted, grid: { stroke: colours.line, width: 1 }, ticks: { stroke: colours.line, width: 1 } };
  const stepped = uPlot.paths.stepped!({ align: 1 });
  return {
    width,
    height: HEIGHT,
    legend: { show: false },
    cursor: { y: false, drag: { x: false, y: false } },
    scales: { x: { time: false, range: [0, run.end || 1] } },
    axes: [
      { ...axis, size: 30, values: (_, values) => values.map((value) => `${digits(value, 6)} s`) },
      { ...axis, size: 56, values: (_, values) => values.map((value) => digits(value, 4)) },
    ],
    series: [
      {},
      {
        stroke: colours.strong,
        width: 1.5,
        points: { show: series.times.length < 60, size: 5, fill: colours.strong },
        ...(series.kind === "variable" ? { paths: stepped } : {}),
      },
    ],
    hooks: {
      draw: [
        (plot) => {
          const x = plot.valToPos(state.time.value, "x", true);
          plot.ctx.fillStyle = colours.cursor;
          plot.ctx.fillRect(x - devicePixelRatio, plot.bbox.top, 2 * devicePixelRatio, plot.bbox.height);
        },
      ],
      ready: [
        (plot) =>
          plot.over.addEventListener("click", () => {
            const left = plot.cursor.left ?? -1;
            if (left >= 0) state.time.value = Math.max(0, Math.min(run.end, plot.posToVal(left, "x")));
          }),
      ],
    },
  };
}

/** Speeds of everything that moves, then the series of the trace. */
function allSeries(run: RunModel): Series[] {
  const speeds = run.tracks.tracks.flatMap((track): Series[] => {
    const values = track.times.map((_, index) => track.speed(index));
    if (!values.some((value) => value > 0.02)) return [];
    return [{ kind: "entity", name: `${track.name}: speed`, unit: "m/s", times: track.times, values }];
  });
  const order = ["entity", "variable", "event"];
  const others = [...run.series].sort((a, b) => order.indexOf(a.kind) - order.indexOf(b.kind));
  return [...speeds, ...others];
}
