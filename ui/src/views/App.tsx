// The page of a report.
import { plain } from "../text";
import { RunViews, type ViewProps } from "./RunViews";
import { Verdict } from "./Verdict";

export function App({ run, state }: ViewProps) {
  return (
    <>
      <a class="skip" href="#timeline">
        Skip to the timeline
      </a>
      <header>
        <Verdict run={run} state={state} />
      </header>
      <main>
        <RunViews run={run} state={state} />
      </main>
      <footer>
        Recorded with seoro {run.meta.start?.version ?? ""}: {plain(run.meta.start?.file ?? "")}
      </footer>
    </>
  );
}
