// The scenario with what ran, what failed and what never ran.
import { useEffect, useMemo, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import { lineOf, type Row } from "../data/rows";
import { Cell, useCell, useRevision } from "../state";
import { clip, plain, plural } from "../text";
import type { ViewProps } from "./RunViews";
import { VirtualList } from "./VirtualList";

const NO_MARKS = new Cell<ReadonlyMap<string, string>>(new Map());
const NOWHERE = new Cell("");
const LONGEST = 2_000; // characters of a line

export function Source({ run, state }: ViewProps) {
  const files = useMemo(() => run.meta.sources.filter((source) => typeof source.text === "string"), [run, run.meta.sources]);
  useRevision(run);
  const byFile = useMemo(() => rowsByLine(run), [run, run.rows.started.length]);
  const place = useCell(state.place);
  const marks = useCell(state.lines?.marks ?? NO_MARKS);
  const paused = useCell(state.lines?.paused ?? NOWHERE);
  const time = useCell(state.time);
  const [chosen, setName] = useState("");
  const own = files.find((source) => source.name === run.meta.start?.file) ?? files[0]; // imports come first
  const name = chosen || (own?.name ?? "");
  const [focus, setFocus] = useState(-1);
  useEffect(() => {
    const [file, line] = lineOf(place);
    if (line === 0 || !files.some((source) => source.name === file)) return;
    setName(file);
    setFocus(line - 1);
  }, [place, files]);
  const file = files.find((source) => source.name === name);
  const lines = useMemo(() => file?.text?.split("\n") ?? [], [file]);
  if (file === undefined) return <NoSource run={run} place={place} />;
  const rows = byFile.get(name) ?? new Map<number, Row[]>();
  const [failed, failedLine] = lineOf(run.meta.end?.source ?? "");
  const choose = (index: number) => {
    for (const row of rows.get(index + 1) ?? []) {
      const found = run.runAt(row, time);
      const shown = found >= 0 ? found : row.runs[0];
      if (shown !== undefined) state.choose(run.behaviors.startSeq[shown]!, run.behaviors.start[shown]!);
    }
  };
  return (
    <div class="source">
      {files.length > 1 && (
        <div class="tools">
          <label>
            <span class="name">file</span>{" "}
            <select value={name} onChange={(event) => setName(event.currentTarget.value)}>
              {files.map((source) => (
                <option key={source.name}>{source.name}</option>
              ))}
            </select>
          </label>
        </div>
      )}
      <Legend />
      <VirtualList
        count={lines.length}
        label="Source"
        focus={focus}
        wide
        onChoose={choose}
        onOtherKey={(key, index) => key.toLowerCase() === "b" && state.lines?.toggle(name, index + 1)}
        line={(index) => (
          <SourceLine
            run={run}
            text={lines[index]!}
            number={index + 1}
            rows={rows.get(index + 1) ?? []}
            time={time}
            isVerdict={failed === name && failedLine === index + 1}
            sign={marks.get(`${name}:${index + 1}`) ?? ""}
            isPaused={paused === `${name}:${index + 1}`}
            onMark={state.lines === null ? null : () => state.lines?.toggle(name, index + 1)}
          />
        )}
      />
    </div>
  );
}

function Legend() {
  return (
    <p class="legend">
      <span class="mark succeeded">✓</span> ran <span class="mark failed">✗</span> failed{" "}
      <span class="mark cancelled">–</span> cancelled <span class="mark never">○</span> never ran{" "}
      <span class="swatch" aria-hidden="true" /> running at this time
    </p>
  );
}

interface LineProps {
  run: RunModel;
  text: string;
  number: number;
  rows: Row[];
  time: number;
  isVerdict: boolean;
  /** Sign at the number of the line. */
  sign: string;
  isPaused: boolean;
  onMark: (() => void) | null;
}

function SourceLine({ run, text, number, rows, time, isVerdict, sign, isPaused, onMark }: LineProps) {
  const [mark, status, words] = markOf(rows, isVerdict);
  const isRunning = rows.some((row) => {
    const index = run.runAt(row, time);
    return index >= 0 && run.behaviors.end[index]! > time;
  });
  const states = [status, isRunning && "running-now", isVerdict && "verdict-line", isPaused && "paused"].filter(Boolean);
  const toggle = (event: Event) => {
    event.stopPropagation();
    onMark?.();
  };
  return (
    <span class={`code ${states.join(" ")}`} title={words}>
      {onMark === null ? (
        <span class="number">{number}</span>
      ) : (
        <span class="number marks" title="Click to set or remove a breakpoint" onClick={toggle}>
          {sign && <span class="stop-sign">{sign}</span>}
          {isPaused && <span class="here">▶</span>}
          {number}
        </span>
      )}
      <span class={`mark ${status}`}>
        <span aria-hidden="true">{mark}</span>
        <span class="hidden">{words}</span>
      </span>
      {text.slice(0, text.length - text.trimStart().length)}
      <span class="text">{clip(plain(text.trimStart()), LONGEST)}</span>
    </span>
  );
}

function markOf(rows: Row[], isVerdict: boolean): [mark: string, status: string, words: string] {
  if (rows.length === 0) return isVerdict ? ["✗", "failed", "decided the verdict"] : ["", "", ""];
  const [running, succeeded, failed, cancelled] = [0, 1, 2, 3].map((status) =>
    rows.reduce((sum, row) => sum + row.counts[status as 0 | 1 | 2 | 3], 0),
  ) as [number, number, number, number];
  const total = running + succeeded + failed + cancelled;
  const words = total === 0 ? "never ran" : `${plural(total, "execution")}, ${failed} failed, ${cancelled} cancelled`;
  if (total === 0) return ["○", "never", words];
  if (failed > 0) return ["✗", "failed", words];
  if (succeeded > 0) return ["✓", "succeeded", words];
  return cancelled > 0 ? ["–", "cancelled", words] : ["▶", "running", words];
}

/** Rows of behaviors by file and line of their start. */
function rowsByLine(run: RunModel): Map<string, Map<number, Row[]>> {
  const found = new Map<string, Map<number, Row[]>>();
  for (const row of run.rows.all) {
    const [file, line] = lineOf(row.source);
    if (line === 0) continue;
    let lines = found.get(file);
    if (lines === undefined) found.set(file, (lines = new Map()));
    const others = lines.get(line);
    if (others === undefined) lines.set(line, [row]);
    else others.push(row);
  }
  return found;
}

function NoSource({ run, place }: { run: RunModel; place: string }) {
  return (
    <div class="empty">
      <p>The trace has no text of the scenario. Traces of seoro have it since format 1.1.</p>
      {place !== "" && <p>The place is {plain(place)}.</p>}
      {run.meta.start?.file && <p>The scenario is {plain(run.meta.start.file)}.</p>}
    </div>
  );
}
