// The views of a run: time, world, tabs, timeline, chosen record.
import { useEffect } from "preact/hooks";
import type { RunModel } from "../data/model";
import { type PageState, TABS, type Tab, useCell, useRevision } from "../state";
import { Coverage } from "./Coverage";
import { Detail } from "./Detail";
import { Plots } from "./Plots";
import { RecordList } from "./RecordList";
import { Source } from "./Source";
import { Timeline } from "./Timeline";
import { Transport, startPlaying } from "./Transport";
import { Values } from "./Values";
import { World } from "./World";

export interface ViewProps {
  run: RunModel;
  state: PageState;
}

const LOGS = ["log.debug", "log.info", "log.warning", "log.error"];

export function RunViews({ run, state }: ViewProps) {
  useEffect(() => startPlaying(run, state), [run, state]);
  useRevision(run);
  const hasWorld = !run.tracks.isEmpty || run.meta.scene?.extent !== undefined;
  return (
    <>
      <Transport run={run} state={state} />
      <div class={hasWorld ? "columns" : "columns one"}>
        {hasWorld && <World run={run} state={state} />}
        <Tabs run={run} state={state} />
      </div>
      <Timeline run={run} state={state} />
      <Detail run={run} state={state} />
    </>
  );
}

function Tabs({ run, state }: ViewProps) {
  const chosen = useCell(state.tab);
  const tabs = TABS.filter((tab) => isUseful(run, tab));
  const choose = (tab: Tab) => {
    state.tab.value = tab;
    document.getElementById(`tab-${tab}`)?.focus();
  };
  const onKey = (event: KeyboardEvent) => {
    const index = tabs.indexOf(chosen);
    const moves: Record<string, number> = {
      ArrowRight: index + 1,
      ArrowLeft: index - 1,
      Home: 0,
      End: tabs.length - 1,
    };
    const next = moves[event.key];
    if (next === undefined) return;
    event.preventDefault();
    choose(tabs[(next + tabs.length) % tabs.length]!);
  };
  return (
    <section class="panel tabs" aria-label="Details of the run">
      <div role="tablist" aria-label="Views" onKeyDown={onKey}>
        {tabs.map((tab) => (
          <button
            role="tab"
            id={`tab-${tab}`}
            key={tab}
            aria-selected={tab === chosen}
            aria-controls="tab-content"
            tabIndex={tab === chosen ? 0 : -1}
            onClick={() => choose(tab)}
          >
            {tab}
          </button>
        ))}
      </div>
      <div role="tabpanel" id="tab-content" aria-labelledby={`tab-${chosen}`} class="content">
        {chosen === "Source" && <Source run={run} state={state} />}
        {chosen === "Log" && <RecordList run={run} state={state} kinds={LOGS} key="log" empty="The run logged nothing." />}
        {chosen === "Records" && <RecordList run={run} state={state} kinds={null} key="all" empty="No records." />}
        {chosen === "Plots" && <Plots run={run} state={state} />}
        {chosen === "Values" && <Values run={run} state={state} />}
        {chosen === "Coverage" && <Coverage run={run} />}
      </div>
    </section>
  );
}

function isUseful(run: RunModel, tab: Tab): boolean {
  const hasCoverage = (run.meta.coverage.coverage?.length ?? 0) > 0 || run.meta.samples.length > 0;
  return tab !== "Coverage" || hasCoverage;
}
