// The tree of behaviors over time. Rows are behaviors of the scenario; bars are their executions.
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import type { Row } from "../data/rows";
import { drawRow, ROW_HEIGHT, toTime, toX, type Window } from "../draw/bars";
import { drawAxis } from "../draw/axis";
import { panned, type Span, wholeSpan, zoomed } from "../draw/spans";
import { onThemeChange, prepare, theme } from "../draw/theme";
import { useCell, useRevision } from "../state";
import { plural } from "../text";
import type { ViewProps } from "./RunViews";
import { Label, labelOf } from "./TimelineLabel";

const TALLEST = 16; // rows, before the list scrolls
const MANY = 200; // rows, from which deep ones are folded at first
const DEEP = 3;
const AXIS = 34; // [px]

export function Timeline(props: ViewProps) {
  useRevision(props.run);
  return props.run.rows.roots.length > 0 ? <Behaviors {...props} /> : <NoBehaviors />;
}

/** A run that has not begun, or a trace that was made from a bag. */
function NoBehaviors() {
  return (
    <section class="panel timeline" id="timeline" aria-label="Timeline" tabIndex={-1}>
      <div class="head">
        <h2>Timeline</h2>
      </div>
      <p class="empty">No behavior started.</p>
    </section>
  );
}

function Behaviors({ run, state }: ViewProps) {
  const [folded, setFolded] = useState(() => foldedAtFirst(run));
  const rows = useMemo(() => visibleRows(run.rows.roots, folded), [run, folded, run.rows.started.length]);
  const [active, setActive] = useState(() => firstFailed(rows));
  const [top, setTop] = useState(0);
  const [zoomedSpan, setSpan] = useState<Span | null>(null); // null for everything, also of a run that grows
  const span = zoomedSpan ?? wholeSpan(run);
  const [width, setWidth] = useState(600);
  const scroll = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const axis = useRef<HTMLCanvasElement>(null);
  const cursor = useRef<HTMLDivElement>(null);
  const pointer = useRef<HTMLDivElement>(null);
  const chosen = useCell(state.record);
  const height = Math.min(Math.max(rows.length, 1), TALLEST) * ROW_HEIGHT;
  const view: Window = { start: span[0], end: span[1], width };
  const first = Math.floor(top / ROW_HEIGHT);
  const shown = rows.slice(first, first + Math.ceil(height / ROW_HEIGHT) + 1);

  useLayoutEffect(() => {
    const observer = new ResizeObserver(([entry]) => setWidth(Math.max(entry!.contentRect.width, 60)));
    observer.observe(canvas.current!.parentElement!);
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    const draw = () => {
      const colours = theme();
      const context = prepare(canvas.current!, width, height);
      context.font = colours.font;
      context.textBaseline = "middle";
      shown.forEach((row, index) => {
        const y = (first + index) * ROW_HEIGHT - top;
        if (first + index === active) {
          context.fillStyle = colours.chosen;
          context.fillRect(0, y, width, ROW_HEIGHT);
        }
        drawRow(context, run, row, view, y, colours);
      });
      drawAxis(axis.current!, run, view, AXIS, colours);
    };
    draw();
    return onThemeChange(draw);
  });
  useEffect(() => {
    const place = () => {
      // The end of a run that grows may be later than that of the drawn bars.
      const x = toX(view, zoomedSpan === null ? Math.min(state.time.value, view.end) : state.time.value);
      const isVisible = x >= 0 && x <= width;
      for (const mark of [cursor.current, pointer.current]) {
        if (mark === null) continue;
        mark.hidden = !isVisible;
        if (isVisible) mark.style.transform = `translateX(${x}px)`;
      }
    };
    place();
    return state.time.subscribe(place);
  });

  const bring = (index: number) => {
    const box = scroll.current!;
    const y = index * ROW_HEIGHT;
    if (y < box.scrollTop) box.scrollTop = y;
    else if (y + ROW_HEIGHT > box.scrollTop + height) box.scrollTop = y + ROW_HEIGHT - height;
  };
  const move = (index: number) => {
    const next = Math.max(0, Math.min(rows.length - 1, index));
    setActive(next);
    bring(next);
  };
  const fold = (row: Row, isFolded: boolean) => {
    const next = new Set(folded);
    if (isFolded) next.add(row.index);
    else next.delete(row.index);
    setFolded(next);
  };
  const zoom = (factor: number, around = state.time.value) => setSpan(zoomed(run, span, factor, around));
  const pan = (share: number) => setSpan(panned(run, span, share));
  const choose = (row: Row | undefined, time: number, isExact: boolean) => {
    if (row === undefined) return;
    const index = isExact ? nearest(run, row, time, view) : run.runAt(row, time);
    const found = index >= 0 ? index : row.runs[0];
    if (found === undefined) {
      state.showPlace(row.source);
      return;
    }
    const { startSeq, endSeq, start, end, status } = run.behaviors;
    const hasFailed = status[found] === 2 && endSeq[found]! >= 0;
    state.choose(hasFailed ? endSeq[found]! : startSeq[found]!, hasFailed ? end[found]! : start[found]!);
  };
  const onKey = (event: KeyboardEvent) => {
    const row = rows[active];
    if (row === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    const keys: Record<string, () => void> = {
      ArrowDown: () => move(active + 1),
      ArrowUp: () => move(active - 1),
      PageDown: () => move(active + TALLEST - 1),
      PageUp: () => move(active - TALLEST + 1),
      Home: () => move(0),
      End: () => move(rows.length - 1),
      ArrowRight: () =>
        row.children.length > 0 && folded.has(row.index) ? fold(row, false) : row.children.length > 0 && move(active + 1),
      ArrowLeft: () => {
        if (row.children.length > 0 && !folded.has(row.index)) fold(row, true);
        else if (row.parent !== null) move(rows.indexOf(row.parent));
      },
      Enter: () => choose(row, state.time.value, false),
      "+": () => zoom(0.5),
      "-": () => zoom(2),
      "0": () => setSpan(null),
      "<": () => pan(-0.25),
      ">": () => pan(0.25),
      ",": () => step(run, state, row, -1),
      ".": () => step(run, state, row, 1),
    };
    const action = keys[event.key];
    if (action === undefined) return;
    event.preventDefault();
    action();
  };
  const timeOf = (event: MouseEvent) =>
    toTime(view, event.clientX - canvas.current!.getBoundingClientRect().left);
  const rowOf = (event: MouseEvent) =>
    first + Math.floor((event.clientY - canvas.current!.getBoundingClientRect().top + top - first * ROW_HEIGHT) / ROW_HEIGHT);
  const onWheel = (event: WheelEvent) => {
    if (event.ctrlKey) {
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, timeOf(event));
    } else if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
      event.preventDefault();
      pan(event.deltaX / width);
    }
  };
  const setTime = (event: PointerEvent) => state.show(Math.max(0, Math.min(run.end, timeOf(event))));
  return (
    <section class="panel timeline" id="timeline" aria-label="Timeline" tabIndex={-1}>
      <div class="head">
        <h2>Timeline</h2>
        <span class="count">{plural(run.behaviors.count, "behavior")}</span>
        <div class="buttons">
          <button type="button" aria-label="Zoom in" onClick={() => zoom(0.5)}>
            +
          </button>
          <button type="button" aria-label="Zoom out" onClick={() => zoom(2)}>
            −
          </button>
          <button type="button" onClick={() => setSpan(null)}>
            Fit
          </button>
          <button type="button" onClick={() => setFolded(folded.size > 0 ? new Set() : foldedAll(run))}>
            {folded.size > 0 ? "Unfold" : "Fold"}
          </button>
        </div>
      </div>
      <div class="axis">
        <span class="name">
          {run.eventTimes.length > 0 ? plural(run.eventTimes.length, "event") : "time of the run"}
        </span>
        <div class="bars">
          <canvas
            ref={axis}
            aria-hidden="true"
            style={{ height: `${AXIS}px` }}
            onPointerDown={(event) => {
              event.currentTarget.setPointerCapture(event.pointerId);
              setTime(event);
            }}
            onPointerMove={(event) => event.buttons > 0 && setTime(event)}
          />
          <div ref={pointer} class="pointer" aria-hidden="true" />
        </div>
      </div>
      <div
        ref={scroll}
        class="scroll"
        role="tree"
        tabIndex={0}
        aria-label="Behaviors"
        aria-describedby="timeline-keys"
        {...(active >= first && active < first + shown.length ? { "aria-activedescendant": `row-${active}` } : {})}
        style={{ height: `${height}px` }}
        onScroll={(event) => setTop(event.currentTarget.scrollTop)}
        onKeyDown={onKey}
      >
        <div role="presentation" style={{ height: `${rows.length * ROW_HEIGHT}px` }}>
          <div role="presentation" class="window" style={{ height: `${height}px` }}>
            <div role="presentation" class="labels">
              {shown.map((row, index) => (
                <Label
                  key={row.index}
                  row={row}
                  text={labelOf(run, row)}
                  number={first + index}
                  y={(first + index) * ROW_HEIGHT - top}
                  isActive={first + index === active}
                  isFolded={folded.has(row.index)}
                  onFold={() => fold(row, !folded.has(row.index))}
                  onChoose={() => {
                    setActive(first + index);
                    choose(row, state.time.value, false);
                  }}
                />
              ))}
            </div>
            <div role="presentation" class="bars">
              <canvas
                ref={canvas}
                aria-hidden="true"
                style={{ height: `${height}px` }}
                onWheel={onWheel}
                onClick={(event) => {
                  const index = rowOf(event);
                  setActive(index);
                  choose(rows[index], timeOf(event), true);
                }}
              />
              <div ref={cursor} class="cursor" aria-hidden="true" />
            </div>
          </div>
        </div>
      </div>
      <p class="legend" id="timeline-keys">
        Keys: arrows move and fold, Enter chooses, + and − zoom, &lt; and &gt; pan, 0 fits, comma and dot step through
        executions.
        {chosen === null ? " Choose a bar to see why it started or ended." : ""}
      </p>
    </section>
  );
}

function visibleRows(roots: Row[], folded: ReadonlySet<number>): Row[] {
  const found: Row[] = [];
  const waiting = [...roots].reverse();
  for (let row = waiting.pop(); row !== undefined; row = waiting.pop()) {
    found.push(row);
    if (!folded.has(row.index)) for (let index = row.children.length - 1; index >= 0; index--) waiting.push(row.children[index]!);
  }
  return found;
}

/** Fold deep rows of large trees, but for those with failures. */
function foldedAtFirst(run: RunModel): Set<number> {
  if (run.rows.all.length < MANY) return new Set();
  const isDeep = (row: Row) => row.children.length > 0 && row.depth >= DEEP && row.counts[2] === 0;
  return new Set(run.rows.all.filter(isDeep).map((row) => row.index));
}

function foldedAll(run: RunModel): Set<number> {
  return new Set(run.rows.all.filter((row) => row.children.length > 0 && row.depth > 0).map((row) => row.index));
}

/** The deepest of the first rows that failed. */
function firstFailed(rows: Row[]): number {
  let found = 0;
  rows.forEach((row, index) => {
    if (row.counts[2] > 0 && (found === 0 || row.depth > rows[found]!.depth)) found = index;
  });
  return found;
}

/** Execution of a row at a time, or the nearest one within some pixels; -1 for none. */
function nearest(run: RunModel, row: Row, time: number, view: Window): number {
  const reach = (6 / view.width) * (view.end - view.start);
  const index = run.runAt(row, time + reach);
  return index >= 0 && run.behaviors.end[index]! >= time - reach ? index : -1;
}

/** Go to the next or the previous execution of a row. */
function step(run: RunModel, state: ViewProps["state"], row: Row, by: 1 | -1): void {
  const at = row.runs.indexOf(run.runAt(row, state.time.value));
  const index = row.runs[Math.max(0, Math.min(row.runs.length - 1, at + by))];
  if (index !== undefined) state.choose(run.behaviors.startSeq[index]!, run.behaviors.start[index]!);
}
