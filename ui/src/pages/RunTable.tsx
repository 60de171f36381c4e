// Table of runs, of which only the visible rows are in the page.
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { useNarrow, useNow } from "../app/hooks";
import { Link, runPath } from "../app/router";
import { StatusBadge } from "../app/Status";
import type { Run } from "../app/types";
import { clock, nameOf, took } from "../app/words";
import { clip, plain } from "../text";

const HEIGHT = 38; // [px] of a row
const TALL = 84; // [px] of a row of a narrow page
const MORE = 6; // rows above and below

interface Props {
  runs: readonly Run[];
  chosen: readonly string[];
  onChoose: (id: string, isChosen: boolean) => void;
  hasPlaces: boolean;
}

export function RunTable({ runs, chosen, onChoose, hasPlaces }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(400);
  const isNarrow = useNarrow(760);
  const size = isNarrow ? TALL : HEIGHT;
  useLayoutEffect(() => {
    const element = box.current!;
    const observer = new ResizeObserver(() => setHeight(element.clientHeight));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  useEffect(() => setTop(box.current!.scrollTop), [runs.length]);
  const first = Math.max(0, Math.min(Math.floor(top / size) - MORE, runs.length - 1));
  const visible = runs.slice(first, first + Math.ceil(height / size) + 2 * MORE);
  const now = useNow(visible.some((run) => run.status === "running"));
  const onKey = (event: KeyboardEvent) => {
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const row = (event.target as HTMLElement).closest<HTMLElement>("[data-row]");
    if (by === undefined || row === null) return;
    event.preventDefault();
    box.current!.querySelector<HTMLElement>(`[data-row="${Number(row.dataset["row"]) + by}"] a`)?.focus();
  };
  return (
    <div
      class={`runs${isNarrow ? " narrow" : ""}${hasPlaces ? "" : " one-place"}`}
      role="table"
      aria-label="Runs, the latest first"
      aria-rowcount={runs.length + 1}
    >
      <div role="rowgroup" class="run-head">
        <div role="row" class="run-row" aria-rowindex={1}>
          <span role="columnheader">Status</span>
          <span role="columnheader">Scenario</span>
          {hasPlaces && <span role="columnheader">Place</span>}
          <span role="columnheader">Started</span>
          <span role="columnheader">Took</span>
          <span role="columnheader">Details</span>
          <span role="columnheader">
            <span class="hidden">Compare</span>
          </span>
        </div>
      </div>
      <div
        ref={box}
        class="run-box"
        role="presentation"
        style={{ height: `${Math.min(runs.length * size, 20_000)}px` }}
        onScroll={(event) => setTop(event.currentTarget.scrollTop)}
        onKeyDown={onKey}
      >
        <div role="rowgroup" style={{ height: `${runs.length * size}px`, paddingTop: `${first * size}px` }}>
          {visible.map((run, index) => (
            <RunRow
              key={run.id}
              run={run}
              index={first + index}
              now={now}
              hasPlaces={hasPlaces}
              isChosen={chosen.includes(run.id)}
              onChoose={onChoose}
            />
          ))}
        </div>
      </div>
    </div>
  );
}

interface RowProps {
  run: Run;
  index: number;
  now: number;
  hasPlaces: boolean;
  isChosen: boolean;
  onChoose: (id: string, isChosen: boolean) => void;
}

function RunRow({ run, index, now, hasPlaces, isChosen, onChoose }: RowProps) {
  const details = detailsOf(run);
  return (
    <div role="row" class="run-row" data-row={index} aria-rowindex={index + 2}>
      <span role="cell">
        <StatusBadge status={run.status} />
      </span>
      <span role="cell" class="what">
        <Link href={runPath(run.id)}>
          <bdi>{clip(plain(nameOf(run)), 120)}</bdi>
        </Link>{" "}
        <span class="muted file" title={plain(run.file).slice(0, 1000)}>
          <bdi>{clip(plain(run.file.split("/").slice(-2).join("/")), 160)}</bdi>
        </span>
      </span>
      {hasPlaces && (
        <span role="cell" class="where">
          <bdi>{clip(plain(run.place), 60)}</bdi>
        </span>
      )}
      <span role="cell" class="when">
        {clock(run.started ?? run.submitted)}
      </span>
      <span role="cell" class="took">
        {took(run.started, run.ended, now)}
      </span>
      <span role="cell" class="why" title={plain(details).slice(0, 1000)}>
        <bdi>{clip(plain(details), 240)}</bdi>
      </span>
      <span role="cell" class="pick">
        <input
          type="checkbox"
          aria-label={`Choose ${clip(plain(nameOf(run)), 60)} to compare`}
          checked={isChosen}
          onChange={(event) => onChoose(run.id, event.currentTarget.checked)}
        />
      </span>
    </div>
  );
}

/** What is worth to know at a glance. */
function detailsOf(run: Run): string {
  if (run.status === "waiting") {
    const place = run.position !== null ? `place ${run.position} in the queue` : "";
    return [place, run.waits && `waits for ${run.waits}`].filter(Boolean).join(", ");
  }
  if (run.reason) return run.reason;
  const who = run.by ? `by ${run.by}` : "";
  return [run.robots.join(", "), who].filter(Boolean).join(", ");
}
