// Breakpoints with their conditions.
import { useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { type PageState, useCell } from "../state";
import { clip, plain } from "../text";
import { Place } from "../views/Place";
import { type Breakpoint, debugSession } from "./session";

export function Breakpoints({ state }: { state: PageState }) {
  const breakpoints = useCell(debugSession.breakpoints);
  const [problem, setProblem] = useState<unknown>(null);
  const act = (action: Promise<void>) => {
    setProblem(null);
    action.catch(setProblem);
  };
  return (
    <div class="breakpoints">
      <h3>Breakpoints</h3>
      {breakpoints.length === 0 && (
        <p class="muted">None. Click the number of a line in the source, or press B there, to pause before its behavior.</p>
      )}
      <ul>
        {breakpoints.map((each) => (
          <li key={`${each.file}:${each.line}`}>
            <span class={each.isVerified ? "stop-sign" : "stop-sign off"} aria-hidden="true">
              {each.isVerified ? "●" : "○"}
            </span>{" "}
            <Place source={`${each.file}:${each.line}:1`} state={state} />
            <Condition breakpoint={each} onChange={(condition) => act(debugSession.setCondition(each, condition))} />
            <button
              type="button"
              aria-label={`Remove the breakpoint in line ${each.line}`}
              onClick={() => act(debugSession.toggle(each.file, each.line))}
            >
              ×
            </button>
            {each.message && <span class="failed"> {clip(plain(each.message), 300)}</span>}
          </li>
        ))}
      </ul>
      {problem !== null && <Problem error={problem} />}
    </div>
  );
}

function Condition({ breakpoint, onChange }: { breakpoint: Breakpoint; onChange: (condition: string) => void }) {
  return (
    <label class="condition">
      <span class="name">if</span>{" "}
      <input
        value={breakpoint.condition}
        placeholder="always"
        aria-label={`Condition of the breakpoint in line ${breakpoint.line}`}
        spellcheck={false}
        onChange={(event) => onChange(event.currentTarget.value.trim())}
      />
    </label>
  );
}
