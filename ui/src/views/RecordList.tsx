// Records of the trace as sentences, with filters.
import { useEffect, useMemo, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import { sentence } from "../data/sentences";
import type { TraceRecord } from "../data/types";
import { after } from "../data/unpack";
import { useRevision } from "../state";
import { plural } from "../text";
import type { ViewProps } from "./RunViews";
import { VirtualList } from "./VirtualList";

const GROUPS: [string, (kind: string) => boolean][] = [
  ["all", () => true],
  ["behaviors", (kind) => /^(behavior|attempt|instance|run)/.test(kind)],
  ["events", (kind) => kind === "event"],
  ["variables", (kind) => kind === "variable"],
  ["log", (kind) => kind.startsWith("log.")],
  ["failures", () => true],
];
const LEVELS: [string, string[]][] = [
  ["all levels", ["log.debug", "log.info", "log.warning", "log.error"]],
  ["info and above", ["log.info", "log.warning", "log.error"]],
  ["warnings and errors", ["log.warning", "log.error"]],
];
const MARKS: Record<string, string> = {
  "behavior.start": "▶",
  "event": "@",
  "variable": "=",
  "log": "“",
  "cover": "#",
  "record": "#",
  "margin": "↔",
};

const LOOK = 80; // [ms] between two searches for the record of the time
const REFRESH = 500; // [ms] between two looks at the new records of a run

interface Props extends ViewProps {
  /** Kinds of records to show; null for all. */
  kinds: string[] | null;
  empty: string;
}

export function RecordList({ run, state, kinds, empty }: Props) {
  const [choice, setChoice] = useState(0);
  const [search, setSearch] = useState("");
  const isLog = kinds !== null;
  const isFailures = !isLog && GROUPS[choice]![0] === "failures";
  const wanted = useMemo(() => {
    const accepted = isLog
      ? (kind: string) => LEVELS[choice]![1].includes(kind)
      : isFailures
        ? (kind: string) => /^(behavior\.end|run\.end|attempt\.end|log\.error)$/.test(kind)
        : GROUPS[choice]![1];
    const numbers = new Set(run.meta.kinds.flatMap((kind, number) => (accepted(kind) ? [number] : [])));
    return positionsOf(run.records.kinds, numbers, run.meta.kinds.length);
  }, [run, isLog, choice, useRevision(run, REFRESH)]);
  const text = isFailures && search === "" ? FAILED : search;
  const [positions, progress] = useSearch(run, wanted, text);
  const [, redraw] = useState(0);
  const [now, setNow] = useState(-1);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    let isCurrent = true;
    const look = () => {
      timer = undefined;
      void run.records.until(state.time.value).then((position) => isCurrent && setNow(after(positions, position) - 1));
    };
    look();
    // While the time moves, not every block on the way is worth to be read.
    const stop = state.time.subscribe(() => (timer ??= setTimeout(look, LOOK)));
    return () => {
      isCurrent = false;
      clearTimeout(timer);
      stop();
    };
  }, [run, state, positions]);

  const line = (index: number) => {
    const record = run.records.ready(positions[index]!, () => redraw((count) => count + 1));
    if (record === null) return <span class="text muted">…</span>;
    return <RecordLine run={run} record={record} isNow={index === now} />;
  };
  const choose = (index: number) => {
    void run.records.at(positions[index]!).then((record) => record && state.choose(record.seq, record.t));
  };
  return (
    <div class="records">
      <div class="tools">
        <label>
          <span class="name">show</span>{" "}
          <select value={String(choice)} onChange={(event) => setChoice(Number(event.currentTarget.value))}>
            {(isLog ? LEVELS : GROUPS).map(([name], index) => (
              <option key={name} value={String(index)}>
                {name}
              </option>
            ))}
          </select>
        </label>
        <label class="search">
          <span class="name">search</span>{" "}
          <input type="search" value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
        </label>
        <span class="count" role="status">
          {progress < 1 ? `searching, ${Math.round(100 * progress)} %` : plural(positions.length, isLog ? "message" : "record")}
        </span>
      </div>
      {positions.length === 0 && progress >= 1 ? (
        <p class="empty">{search === "" && choice === 0 ? empty : "Nothing matches. Change the filter or the search."}</p>
      ) : (
        <VirtualList count={positions.length} label={isLog ? "Log" : "Records"} focus={now} line={line} onChoose={choose} />
      )}
    </div>
  );
}

function RecordLine({ run, record, isNow }: { run: RunModel; record: TraceRecord; isNow: boolean }) {
  const level = record.kind === "log" ? String(record["level"]) : "";
  const status = record.kind.endsWith(".end") ? String(record["status"]) : "";
  const ends: Record<string, string> = { succeeded: "✓", passed: "✓", failed: "✗", error: "!", cancelled: "–" };
  return (
    <>
      <span class="time">{record.t.toFixed(3)}</span>
      <span class={`mark ${status} ${level}`} aria-hidden="true">
        {ends[status] ?? MARKS[record.kind] ?? "·"}
      </span>
      {level !== "" && level !== "info" && <span class={`level ${level}`}>{level}</span>}
      <bdi class={isNow ? "text now" : "text"}>{sentence(run, record)}</bdi>
    </>
  );
}

function positionsOf(kinds: Uint8Array, wanted: Set<number>, all: number): Int32Array {
  const found = new Int32Array(kinds.length);
  let count = 0;
  const isWanted = new Uint8Array(256);
  for (const number of wanted) isWanted[number] = 1;
  const isAll = wanted.size === all;
  for (let index = 0; index < kinds.length; index++) if (isAll || isWanted[kinds[index]!]) found[count++] = index;
  return found.subarray(0, count);
}

const FAILED = /"status": ?"(failed|error)"|"level": ?"error"/;

/** Positions whose records contain a text, found block by block; with the share that was searched. */
function useSearch(run: RunModel, positions: Int32Array, search: string | RegExp): [Int32Array, number] {
  const [found, setFound] = useState<[Int32Array, number]>([positions, 1]);
  useEffect(() => {
    if (search === "") {
      setFound([positions, 1]);
      return;
    }
    let isCurrent = true;
    const matches = matcher(run, search);
    const work = async () => {
      const hits: number[] = [];
      let index = 0;
      for (let block = 0; block < run.records.blocks && isCurrent; block++) {
        const [first, records] = await run.records.blockAt(block);
        for (; index < positions.length && positions[index]! < first + records.length; index++) {
          if (matches(records[positions[index]! - first]!)) hits.push(positions[index]!);
        }
        if (block % 20 === 0 && isCurrent) setFound([Int32Array.from(hits), block / run.records.blocks]);
      }
      if (isCurrent) setFound([Int32Array.from(hits), 1]);
    };
    const timer = setTimeout(() => void work(), 150);
    return () => {
      isCurrent = false;
      clearTimeout(timer);
    };
  }, [run, positions, search]);
  return found;
}

function matcher(run: RunModel, search: string | RegExp): (record: TraceRecord) => boolean {
  if (typeof search !== "string") return (record) => search.test(JSON.stringify(record));
  const wanted = search.toLowerCase();
  return (record) =>
    sentence(run, record).toLowerCase().includes(wanted) || JSON.stringify(record).toLowerCase().includes(wanted);
}

