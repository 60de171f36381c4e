// Two runs side by side: where they first differ, and both paths in one picture.
import { useEffect, useMemo } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { useAnswer, useTitle } from "../app/hooks";
import { Link, navigate, runPath } from "../app/router";
import { StatusBadge } from "../app/Status";
import type { Shared } from "../app/stores";
import { clock, nameOf, wordOf } from "../app/words";
import type { RunModel } from "../data/model";
import { sentence } from "../data/sentences";
import { ServedRun } from "../data/served";
import type { TraceRecord } from "../data/types";
import { get } from "../net/api";
import { useCell, useRevision } from "../state";
import { clip, duration, plain, seconds, shown } from "../text";
import { BothWorlds } from "./BothWorlds";

interface Side {
  time: number | null;
  records: TraceRecord[];
}

interface Comparison {
  settings: [name: string, a: unknown, b: unknown][];
  difference: { common: number | null; first: Side; second: Side } | null;
}

export function Compare({ query, shared }: { query: string; shared: Shared }) {
  useTitle("Compare runs");
  const values = new URLSearchParams(query);
  const [a, b] = [values.get("a") ?? "", values.get("b") ?? ""];
  return (
    <>
      <div class="title">
        <h1>Compare runs</h1>
      </div>
      <section class="panel pair" aria-label="Runs">
        <Choice name="A" id={a} other={b} shared={shared} onChoose={(id) => navigate(pathOf(id, b))} />
        <Choice name="B" id={b} other={a} shared={shared} onChoose={(id) => navigate(pathOf(a, id))} />
      </section>
      {a === "" || b === "" ? (
        <section class="panel">
          <p class="empty">Choose two runs.</p>
        </section>
      ) : (
        <Compared key={`${a}\n${b}`} a={a} b={b} />
      )}
    </>
  );
}

function pathOf(a: string, b: string): string {
  return `/compare?${new URLSearchParams({ ...(a ? { a } : {}), ...(b ? { b } : {}) })}`;
}

interface ChoiceProps {
  name: string;
  id: string;
  other: string;
  shared: Shared;
  onChoose: (id: string) => void;
}

const MOST = 500; // runs to choose from

function Choice({ name, id, other, shared, onChoose }: ChoiceProps) {
  const all = useCell(shared.runs.runs) ?? [];
  const like = shared.runs.get(other);
  const same = all.filter((run) => like === undefined || (run.scenario === like.scenario && run.file === like.file));
  const chosen = shared.runs.get(id);
  const listed = [...new Set([...(chosen ? [chosen] : []), ...same, ...all])].slice(0, MOST);
  return (
    <label class="field">
      <span class="name">Run {name}</span>
      <select value={id} onChange={(event) => onChoose(event.currentTarget.value)}>
        <option value="">choose…</option>
        {listed.map((run) => (
          <option key={run.id} value={run.id}>
            {clip(plain(nameOf(run)), 60)}, {wordOf(run.status).toLowerCase()}, {clock(run.started ?? run.submitted)},{" "}
            {clip(plain(run.place), 40)}
          </option>
        ))}
      </select>
    </label>
  );
}

function Compared({ a, b }: { a: string; b: string }) {
  const path = `/api/compare?${new URLSearchParams({ a, b })}`;
  const { data, error } = useAnswer(() => get<Comparison>(path), [path]);
  const [first, second] = useMemo(() => [new ServedRun(a), new ServedRun(b)] as const, [a, b]);
  useEffect(
    () => () => {
      first.close();
      second.close();
    },
    [first, second],
  );
  return (
    <>
      {error !== null && <Problem error={error} />}
      <section class="panel" aria-label="Verdicts">
        <div class="columns sides">
          <OneVerdict name="A" served={first} />
          <OneVerdict name="B" served={second} />
        </div>
      </section>
      {error === null && data === null && (
        <section class="panel">
          <p class="empty">Comparing…</p>
        </section>
      )}
      {data !== null && <Difference data={data} first={first} second={second} />}
      {data !== null && data.settings.length > 0 && <Settings settings={data.settings} />}
      <BothWorlds first={first} second={second} at={differsAt(data)} />
    </>
  );
}

function OneVerdict({ name, served }: { name: string; served: ServedRun }) {
  const run = useCell(served.model);
  return (
    <div class={`side side-${name.toLowerCase()}`}>
      <h3>
        <Link href={runPath(served.id)}>Run {name}</Link>
      </h3>
      {run === null ? <p class="muted">Reading the run…</p> : <VerdictText run={run} />}
    </div>
  );
}

function VerdictText({ run }: { run: RunModel }) {
  useRevision(run); // it may be active
  const { end, status = "" } = run.meta;
  return (
    <>
      <p>
        <StatusBadge status={status} /> after {duration(end?.duration ?? run.end)}
      </p>
      {end?.reason && (
        <p class="reason">
          <bdi>{clip(plain(end.reason), 2_000)}</bdi>
        </p>
      )}
      {end?.source && <p class="muted">{clip(plain(end.source), 300)}</p>}
    </>
  );
}

/** Time of the first difference [s]; null for equal runs. */
function differsAt(data: Comparison | null): number | null {
  const times = [data?.difference?.first.time, data?.difference?.second.time].filter((time) => typeof time === "number");
  return times.length === 0 ? null : Math.min(...times);
}

function Difference({ data, first, second }: { data: Comparison; first: ServedRun; second: ServedRun }) {
  const { difference } = data;
  if (difference === null) {
    return (
      <section class="panel" aria-label="First difference">
        <h2>
          <span class="succeeded" aria-hidden="true">
            ＝{" "}
          </span>
          The runs are equal
        </h2>
        <p class="muted">All records are the same but for wall times and poses.</p>
      </section>
    );
  }
  const common = difference.common === null ? "They differ from the beginning." : `They are equal until ${seconds(difference.common)}.`;
  return (
    <section class="panel" aria-label="First difference">
      <h2>The runs first differ at {seconds(differsAt(data) ?? 0)}</h2>
      <p class="muted">{common}</p>
      <div class="columns sides">
        <OneSide name="A" side={difference.first} served={first} />
        <OneSide name="B" side={difference.second} served={second} />
      </div>
    </section>
  );
}

function OneSide({ name, side, served }: { name: string; side: Side; served: ServedRun }) {
  const run = useCell(served.model);
  return (
    <div class={`side side-${name.toLowerCase()}`}>
      <h3>
        Only in <Link href={runPath(served.id)}>run {name}</Link>
        {side.time !== null && `, ${seconds(side.time)}`}
      </h3>
      {side.time === null ? (
        <p class="muted">The run has ended.</p>
      ) : side.records.length === 0 ? (
        <p class="muted">Nothing.</p>
      ) : (
        <ul>
          {side.records.map((record) => (
            <li key={record.seq}>
              <bdi>{run === null ? plain(record.kind) : sentence(run, record)}</bdi>
            </li>
          ))}
        </ul>
      )}
    </div>
  );
}

function Settings({ settings }: { settings: Comparison["settings"] }) {
  return (
    <section class="panel" aria-label="Settings that differ">
      <h2>Settings that differ</h2>
      <div class="scrolls" tabIndex={0} role="region" aria-label="Settings">
        <table class="full">
          <thead>
            <tr>
              <th scope="col">setting</th>
              <th scope="col">A</th>
              <th scope="col">B</th>
            </tr>
          </thead>
          <tbody>
            {settings.map(([name, first, second]) => (
              <tr key={name}>
                <th scope="row">{clip(plain(name), 100)}</th>
                <td>
                  <bdi>{clip(plain(shown(first)), 300)}</bdi>
                </td>
                <td>
                  <bdi>{clip(plain(shown(second)), 300)}</bdi>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </section>
  );
}
