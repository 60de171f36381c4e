// Start a run: choose a scenario, set its parameters, choose where it runs.
import { useMemo, useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { useAnswer, useTitle } from "../app/hooks";
import type { Shared } from "../app/stores";
import { get } from "../net/api";
import { clip, plain, plural } from "../text";
import { type Entry, type ScenarioForm } from "./start_data";
import { StartForm } from "./StartForm";

const MOST = 300; // scenarios in the list

export function Start({ shared }: { shared: Shared }) {
  useTitle("Start a run");
  const { data, error, again } = useAnswer(() => get<{ scenarios: Entry[] }>("/api/scenarios"), []);
  const [search, setSearch] = useState("");
  const [chosen, setChosen] = useState<Entry | null>(null);
  const matching = useMemo(() => (data?.scenarios ?? []).filter((entry) => matches(entry, search)), [data, search]);
  return (
    <>
      <div class="title">
        <h1>Start a run</h1>
        <span class="count">{data && plural(data.scenarios.length, "scenario")}</span>
        <button type="button" onClick={again}>
          Read again
        </button>
      </div>
      {error !== null && <Problem error={error} />}
      {!shared.site.mayStart && (
        <p class="notes" role="status">
          {shared.site.mayAct ? "No executor is reachable: runs cannot be started." : "The keys of this site may watch only."} You can still
          look at scenarios.
        </p>
      )}
      {error === null && (
        <div class="columns start">
          <section class="panel" aria-label="Scenarios">
            <div class="tools">
              <label class="search wide">
                <span class="name">search</span>{" "}
                <input type="search" value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
              </label>
            </div>
            {data === null ? (
              <p class="empty">Reading the scenarios…</p>
            ) : data.scenarios.length === 0 ? (
              <p class="empty">
                No scenario files (<code>.osc</code>) are in the folders that are shown here. Start <code>seoro ui</code> with the folder
                of your scenarios.
              </p>
            ) : matching.length === 0 ? (
              <p class="empty">No scenario matches. Change the search.</p>
            ) : (
              <ScenarioList entries={matching} chosen={chosen} onChoose={setChosen} />
            )}
          </section>
          {chosen === null ? (
            <section class="panel" aria-label="Settings">
              <p class="empty">Choose a scenario to see its parameters.</p>
            </section>
          ) : (
            <Chosen key={`${chosen.file}\n${chosen.name}`} entry={chosen} shared={shared} />
          )}
        </div>
      )}
    </>
  );
}

function ScenarioList({ entries, chosen, onChoose }: { entries: Entry[]; chosen: Entry | null; onChoose: (entry: Entry) => void }) {
  return (
    <>
      <ul class="scenarios">
        {entries.slice(0, MOST).map((entry) => (
          <li key={`${entry.file}\n${entry.name}`}>
            <button
              type="button"
              class="scenario"
              aria-pressed={chosen === entry}
              disabled={Boolean(entry.problem)}
              onClick={() => onChoose(entry)}
            >
              <strong>
                <bdi>{clip(plain(entry.name || entry.file), 120)}</bdi>
              </strong>
              <span class="muted" title={plain(entry.file).slice(0, 1000)}>
                <bdi>{clip(plain(entry.file.split("/").slice(-3).join("/")), 200)}</bdi>
                {entry.line ? `:${entry.line}` : ""}
              </span>
              {entry.doc && <span>{clip(plain(entry.doc), 240)}</span>}
              {entry.problem && (
                <span class="failed">
                  <span aria-hidden="true">✗ </span>
                  {clip(plain(entry.problem), 300)}
                </span>
              )}
            </button>
          </li>
        ))}
      </ul>
      {entries.length > MOST && <p class="muted">{plural(entries.length - MOST, "further scenario")}: search.</p>}
    </>
  );
}

function Chosen({ entry, shared }: { entry: Entry; shared: Shared }) {
  const path = `/api/scenario?file=${encodeURIComponent(entry.file)}&name=${encodeURIComponent(entry.name)}`;
  const { data, error } = useAnswer(() => get<ScenarioForm>(path), [path]);
  return (
    <section class="panel" aria-label="Settings">
      <h2 class="chosen">
        <bdi>{clip(plain(entry.name), 160)}</bdi>
      </h2>
      {error !== null && <Problem error={error} />}
      {error === null && data === null && <p class="empty">Reading the scenario…</p>}
      {data?.problem && <Problem error={new Error(data.problem)} />}
      {data !== null && !data.problem && <StartForm entry={entry} form={data} shared={shared} />}
    </section>
  );
}

function matches(entry: Entry, search: string): boolean {
  const text = `${entry.name}\n${entry.file}\n${entry.doc ?? ""}`.toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}
