// The verdict and its reason, first of all.
import { useState } from "preact/hooks";
import { lineOf } from "../data/rows";
import { sourceLine } from "../data/sentences";
import type { Activity, Emitter, Value } from "../data/types";
import { useRevision } from "../state";
import { clip, duration, plain, plural, seconds, shown, whole } from "../text";
import type { ViewProps } from "./RunViews";
import { Place } from "./Place";

const WORDS: Record<string, [word: string, icon: string]> = {
  passed: ["Passed", "✓"],
  failed: ["Failed", "✗"],
  error: ["Error", "!"],
  cancelled: ["Cancelled", "–"],
};
const VERBS: Record<string, string> = { waits: "waiting", runs: "running", holds: "held" };

export function Verdict({ run, state }: ViewProps) {
  useRevision(run);
  const { start, end, scene, notes } = run.meta;
  const status = end?.status ?? "unended";
  const [word, icon] = WORDS[status] ?? (run.isActive ? ["Running", "▶"] : ["Not ended", "…"]);
  const robots = (scene?.entities ?? []).filter((entity) => entity.kind === "robot");
  return (
    <div class={`verdict ${status}`}>
      <div class="headline">
        <span class="badge">
          <span aria-hidden="true">{icon}</span> {word}
        </span>
        <h1>
          <bdi>{clip(plain(start?.scenario ?? "run"), 200)}</bdi>
        </h1>
      </div>
      {end?.reason ? (
        <p class="reason">
          <bdi>{plain(end.reason)}</bdi> {end.source && <Place source={end.source} state={state} />}
        </p>
      ) : null}
      {end?.source && sourceLine(run, end.source) !== "" && (
        <pre class="quote">
          <span class="number">{lineOf(end.source)[1]}</span> {plain(sourceLine(run, end.source))}
        </pre>
      )}
      <Activities run={run} state={state} />
      <ul class="facts" aria-label="Facts of the run">
        <Fact name="duration" value={duration(end?.duration ?? run.end)} />
        <Fact name="clock" value={start?.clock ?? ""} />
        <Fact name="seed" value={start?.seed === undefined ? "" : String(start.seed)} />
        <Fact name="simulator" value={scene?.simulator ?? ""} />
        <Fact name="world" value={scene?.world ?? ""} />
        {typeof end?.margin === "number" && <Fact name="least margin" value={end.margin.toPrecision(3)} />}
        {Array.isArray(start?.requirements) && <Fact name="requirements" value={start.requirements.map(String).join(", ")} />}
        <Fact name="records" value={whole(run.meta.count)} />
        {robots.slice(0, 20).map((robot) => (
          <li key={robot.name} class={robot.real ? "real" : ""}>
            <span class="name">{robot.real ? "real robot" : "simulated robot"}</span> <bdi>{plain(robot.name)}</bdi>
            {robot.model ? ` (${plain(robot.model)})` : ""}
          </li>
        ))}
        {robots.length > 20 && <li>{plural(robots.length - 20, "further robot")}</li>}
      </ul>
      {run.meta.command !== "" && <Command text={run.meta.command} />}
      {notes.length > 0 && (
        <ul class="notes">
          {notes.map((note) => (
            <li key={note}>{plain(note)}</li>
          ))}
        </ul>
      )}
    </div>
  );
}

function Fact({ name, value }: { name: string; value: string }) {
  if (value === "") return null;
  return (
    <li>
      <span class="name">{name}</span> <bdi>{clip(plain(value), 100)}</bdi>
    </li>
  );
}

function Activities({ run, state }: ViewProps) {
  const explanation = run.meta.end?.explanation;
  if (!explanation) return null;
  const activities = explanation.activities ?? [];
  const values = explanation.values ?? [];
  if (activities.length === 0 && values.length === 0) return null;
  return (
    <div class="activities">
      {values.length > 0 && <Numbers values={values} />}
      {activities.length > 0 && <h2>At {seconds(explanation.t)}</h2>}
      <ul>
        {activities.map((activity) => (
          <li key={activity.path + activity.source}>
            <ActivityText activity={activity} />
            <Place source={activity.source} state={state} />
            <Numbers values={activity.values ?? []} />
            {activity.event && (activity.emitters ?? []).length === 0 && (
              <div class="emitter">
                no <code>emit</code> of <code>{clip(plain(activity.event), 200)}</code> in the scenario
              </div>
            )}
            {(activity.emitters ?? []).map((emitter) => (
              <EmitterText key={emitter.source} emitter={emitter} state={state} />
            ))}
          </li>
        ))}
      </ul>
      {(explanation.more ?? 0) > 0 && <p>{plural(explanation.more!, "further behavior")} did the same.</p>}
    </div>
  );
}

function ActivityText({ activity }: { activity: Activity }) {
  const due = typeof activity.due === "number" ? `, until ${seconds(activity.due)}` : "";
  return (
    <>
      <code>{clip(plain(activity.text), 300)}</code> {VERBS[activity.kind] ?? "active"} since {seconds(activity.since)}
      {due}{" "}
    </>
  );
}

function EmitterText({ emitter, state }: { emitter: Emitter; state: ViewProps["state"] }) {
  const last = typeof emitter.last === "number" ? `was reached at ${seconds(emitter.last)}` : "was not reached";
  return (
    <div class="emitter">
      <code>{clip(plain(emitter.text), 300)}</code> {last} <Place source={emitter.source} state={state} />
      {emitter.after && (
        <>
          : it comes after <code>{clip(plain(emitter.after.text), 300)}</code>{" "}
          <Place source={emitter.after.source} state={state} />
        </>
      )}
    </div>
  );
}

function Numbers({ values }: { values: Value[] }) {
  return (
    <>
      {values.map((value) => (
        <div class="emitter" key={value.text}>
          <code>{clip(plain(value.text), 300)}</code>
          {value.error === undefined
            ? ` = ${clip(plain(value.shown ?? shown(value.value)), 300)}`
            : ` has no value: ${clip(plain(value.error), 300)}`}
        </div>
      ))}
    </>
  );
}

function Command({ text }: { text: string }) {
  const [label, setLabel] = useState("Copy");
  const copy = async () => {
    try {
      await navigator.clipboard.writeText(text);
      setLabel("Copied");
    } catch {
      setLabel("Select it and copy"); // pages from file:// may have no clipboard
    }
  };
  return (
    <div class="command">
      <span class="name">repeat</span>
      <code tabIndex={0}>{plain(text)}</code>
      <button type="button" onClick={() => void copy()}>
        {label}
      </button>
    </div>
  );
}

