// One run: the views of its report, live.
import { useEffect, useMemo, useState } from "preact/hooks";
import { Confirm, Problem } from "../app/Confirm";
import { useTitle } from "../app/hooks";
import { Link } from "../app/router";
import { StatusBadge } from "../app/Status";
import type { Shared } from "../app/stores";
import type { Run as RunData } from "../app/types";
import { nameOf, wordOf } from "../app/words";
import type { RunModel } from "../data/model";
import { ServedRun } from "../data/served";
import { post } from "../net/api";
import { PageState, useCell, useRevision } from "../state";
import { clip, plain } from "../text";
import { RunViews } from "../views/RunViews";
import { Verdict } from "../views/Verdict";
import { DebugPanel } from "../debug/DebugPanel";
import { lineMarks } from "../debug/marks";
import { debugSession } from "../debug/session";
import { Cameras } from "./Cameras";
import { Files } from "./Files";

export function Run({ id, shared }: { id: string; shared: Shared }) {
  const served = useMemo(() => new ServedRun(id), [id]);
  useEffect(() => () => served.close(), [served]);
  useCell(shared.runs.runs); // the entry of the run may change
  const entry = shared.runs.get(id);
  const run = useCell(served.model);
  const socket = useCell(served.socket.state);
  const refusal = useCell(served.socket.refusal);
  const name = run?.meta.start?.scenario ?? (entry ? nameOf(entry) : "Run");
  useTitle(`${entry ? `${wordOf(entry.status)}: ` : ""}${clip(plain(name), 200)}`);
  return (
    <>
      <RunBar id={id} entry={entry} mayAct={shared.site.mayAct} />
      {refusal !== null && <Problem error={new Error([refusal.error, refusal.help].filter(Boolean).join(": "))} />}
      {socket === "lost" && run !== null && (
        <p class="notes" role="status">
          The connection is lost: the picture stands still until it is opened again.
        </p>
      )}
      {run === null || run.meta.count === 0 ? (
        <Before entry={entry} isRefused={refusal !== null} />
      ) : (
        <Following key={id} run={run} served={served} />
      )}
    </>
  );
}

function RunBar({ id, entry, mayAct }: { id: string; entry: RunData | undefined; mayAct: boolean }) {
  const [isStopping, setIsStopping] = useState(false);
  const path = `/api/run/${encodeURIComponent(id)}`;
  const isActive = entry?.status === "running" || entry?.status === "waiting";
  return (
    <div class="run-bar">
      <nav aria-label="Path" class="crumbs">
        <Link href="/runs">Runs</Link>
        {entry && (
          <>
            {" › "}
            <bdi>{clip(plain(entry.place), 60)}</bdi>
          </>
        )}
      </nav>
      <div class="actions">
        {isActive && entry.mayStop && mayAct && (
          <button type="button" class="danger" onClick={() => setIsStopping(true)}>
            ■ Stop…
          </button>
        )}
        <a class="button" href={`${path}/report`} download>
          Download report
        </a>
        <Link class="button" href={`/compare?a=${encodeURIComponent(id)}`}>
          Compare…
        </Link>
      </div>
      {isStopping && (
        <Confirm
          title="Stop this run?"
          action="Stop the run"
          ask="Reason"
          isOptional
          isDangerous
          onConfirm={async (reason) => {
            await post(`${path}/stop`, reason === "" ? {} : { reason });
          }}
          onClose={() => setIsStopping(false)}
        >
          <p>It ends as cancelled, with its robots stopped. What it has recorded stays.</p>
        </Confirm>
      )}
    </div>
  );
}

/** A run without records yet. */
function Before({ entry, isRefused }: { entry: RunData | undefined; isRefused: boolean }) {
  if (isRefused) return null;
  return (
    <section class="panel">
      <h1>
        <bdi>{clip(plain(entry ? nameOf(entry) : "Run"), 200)}</bdi>
      </h1>
      {entry && <StatusBadge status={entry.status} />}
      <p class="empty" role="status">
        {entry?.status === "waiting"
          ? `${entry.position !== null ? `Place ${entry.position} in the queue. ` : ""}${entry.waits ? `Waits for ${clip(plain(entry.waits), 200)}.` : ""}`
          : "Reading the run…"}
      </p>
      {entry?.reason && <p class="reason">{plain(entry.reason)}</p>}
    </section>
  );
}

function Following({ run, served }: { run: RunModel; served: ServedRun }) {
  const isDebugged = useCell(debugSession.run) === served.id;
  const state = useMemo(() => stateOf(run, isDebugged), []);
  useRevision(run); // whether it is active
  useEffect(() => {
    const follow = () => {
      if (state.isFollowing.value) state.time.value = run.end;
      if (!run.isActive) state.isFollowing.value = false;
    };
    follow();
    return run.revision.subscribe(follow);
  }, [run, state]);
  useRealClock(run);
  return (
    <>
      <Verdict run={run} state={state} />
      {isDebugged && <DebugPanel state={state} />}
      <RunViews run={run} state={state} />
      <Cameras id={served.id} isActive={run.isActive} />
      <Files id={served.id} isActive={run.isActive} />
    </>
  );
}

const TICK = 500; // [ms]

/** On the real clock time passes, also while nothing is recorded. */
function useRealClock(run: RunModel): void {
  const isReal = run.isActive && run.meta.start?.clock === "real";
  useEffect(() => {
    const started = Date.parse(String(run.meta.start?.["wall"] ?? ""));
    if (!isReal || Number.isNaN(started)) return;
    const timer = setInterval(() => run.advance((Date.now() - started) / 1000), TICK);
    return () => clearInterval(timer);
  }, [run, isReal]);
}

function stateOf(run: RunModel, isDebugged: boolean): PageState {
  const state = new PageState(run.isActive ? run.end : (run.meta.end?.explanation?.t ?? run.end), run.isActive);
  if (run.meta.end?.source) state.place.value = run.meta.end.source;
  if (!run.meta.sources.some((source) => source.text)) state.tab.value = "Log";
  if (isDebugged) state.lines = lineMarks;
  return state;
}
