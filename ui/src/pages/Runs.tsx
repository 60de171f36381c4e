// All runs: live and past, of this machine and of executors.
import { useMemo, useState } from "preact/hooks";
import { useTitle } from "../app/hooks";
import { Link, navigate } from "../app/router";
import type { Shared } from "../app/stores";
import type { Run } from "../app/types";
import { RUN_STATUSES, wordOf } from "../app/words";
import { useCell } from "../state";
import { clip, plain, plural } from "../text";
import { RunTable } from "./RunTable";

export function Runs({ shared }: { shared: Shared }) {
  useTitle("Runs");
  const runs = useCell(shared.runs.runs);
  const [search, setSearch] = useState("");
  const [status, setStatus] = useState("");
  const [place, setPlace] = useState("");
  const [chosen, setChosen] = useState<readonly string[]>([]);
  const places = useMemo(() => [...new Set((runs ?? []).map((run) => run.place))].sort(), [runs]);
  const matching = useMemo(() => (runs ?? []).filter((run) => matches(run, search, status, place)), [runs, search, status, place]);
  const active = (runs ?? []).filter((run) => run.ended === null && run.status === "running").length;
  const choose = (id: string, isChosen: boolean) =>
    setChosen(isChosen ? [...chosen, id].slice(-2) : chosen.filter((other) => other !== id));
  return (
    <>
      <div class="title">
        <h1>Runs</h1>
        <span class="count" role="status">
          {runs === null ? "" : `${plural(runs.length, "run")}${active > 0 ? `, ${active} running` : ""}`}
        </span>
        {shared.site.mayAct && (
          <Link href="/start" class="button primary">
            Start a run
          </Link>
        )}
      </div>
      <Places shared={shared} />
      <section class="panel" aria-label="Runs">
        <div class="tools">
          <label class="search">
            <span class="name">search</span>{" "}
            <input type="search" value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
          </label>
          <label>
            <span class="name">status</span>{" "}
            <select value={status} onChange={(event) => setStatus(event.currentTarget.value)}>
              <option value="">all</option>
              {RUN_STATUSES.map((name) => (
                <option key={name} value={name}>
                  {wordOf(name).toLowerCase()}
                </option>
              ))}
            </select>
          </label>
          {places.length > 1 && (
            <label>
              <span class="name">place</span>{" "}
              <select value={place} onChange={(event) => setPlace(event.currentTarget.value)}>
                <option value="">all</option>
                {places.map((name) => (
                  <option key={name} value={name}>
                    {clip(plain(name), 40)}
                  </option>
                ))}
              </select>
            </label>
          )}
          <button
            type="button"
            disabled={chosen.length !== 2}
            onClick={() => navigate(`/compare?a=${encodeURIComponent(chosen[0]!)}&b=${encodeURIComponent(chosen[1]!)}`)}
          >
            Compare {chosen.length === 1 ? "(choose one more)" : chosen.length === 2 ? "the 2 chosen" : "two"}
          </button>
          <span class="count" role="status">
            {matching.length !== (runs?.length ?? 0) && `${plural(matching.length, "run")} shown`}
          </span>
        </div>
        {runs === null ? (
          <p class="empty">Reading the runs…</p>
        ) : runs.length === 0 ? (
          <NoRuns />
        ) : matching.length === 0 ? (
          <p class="empty">No run matches. Change the search or the filters.</p>
        ) : (
          <RunTable runs={matching} chosen={chosen} onChoose={choose} hasPlaces={places.length > 1} />
        )}
      </section>
    </>
  );
}

function NoRuns() {
  return (
    <div class="empty big">
      <p>
        <strong>No runs yet.</strong>
      </p>
      <p>
        <Link href="/start">Start a run</Link> from a scenario, or run one with <code>seoro exec FILE -o results/</code> in a folder
        that is shown here.
      </p>
    </div>
  );
}

function Places({ shared }: { shared: Shared }) {
  const broken = shared.site.places.filter((place) => place.problem);
  if (broken.length === 0) return null;
  return (
    <ul class="notes">
      {broken.map((place) => (
        <li key={place.name}>
          <bdi>{clip(plain(place.name), 100)}</bdi>: {clip(plain(place.problem), 300)}
        </li>
      ))}
    </ul>
  );
}

function matches(run: Run, search: string, status: string, place: string): boolean {
  if ((status !== "" && run.status !== status) || (place !== "" && run.place !== place)) return false;
  if (search === "") return true;
  const text = [run.scenario, run.file, run.reason, run.by, run.place, run.status, ...run.robots].join("\n").toLowerCase();
  return search.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}
