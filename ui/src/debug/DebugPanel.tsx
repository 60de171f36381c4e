// Controls of a debugged run: steps, branches, variables, breakpoints, console.
import { useEffect, useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { type PageState, useCell } from "../state";
import { clip, plain, plural } from "../text";
import { Place } from "../views/Place";
import { Breakpoints } from "./Breakpoints";
import { lineMarks } from "./marks";
import { debugSession, type StackFrame, STEPS, type StepName } from "./session";
import { type Branch, type Group, readBranches, readGroups } from "./snapshot";
import { Variables } from "./Variables";

export function DebugPanel({ state }: { state: PageState }) {
  const status = useCell(debugSession.status);
  const text = useCell(debugSession.text);
  const pauses = useCell(debugSession.pauses);
  const [branches, setBranches] = useState<Branch[]>([]);
  const [frame, setFrame] = useState<StackFrame | null>(null);
  const [problem, setProblem] = useState<unknown>(null);
  const isPaused = status === "paused";
  const isOver = status === "ended" || status === "replaced" || status === "lost";
  const act = (action: Promise<void>) => {
    setProblem(null);
    action.catch(setProblem);
  };
  useEffect(() => setProblem(null), [status === "lost"]);
  useEffect(() => {
    if (!isPaused) return;
    readBranches()
      .then((found) => {
        setBranches(found);
        const top = found[0]?.frames[0] ?? null;
        setFrame(top);
        if (top?.source === undefined) return;
        lineMarks.paused.value = `${top.source.name}:${top.line}`;
        state.showPlace(`${top.source.name}:${top.line}:1`);
      })
      .catch((error: unknown) => debugSession.status.value === "paused" && setProblem(error));
  }, [isPaused, pauses]);
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      const steps: Record<string, () => Promise<void>> = {
        F5: () => debugSession.resume(),
        F6: () => debugSession.pause(),
        F10: () => debugSession.step("next"),
        F11: () => debugSession.step(event.shiftKey ? "stepOut" : "stepIn"),
      };
      const step = steps[event.key];
      if (step === undefined || event.ctrlKey || event.metaKey || isOver) return;
      event.preventDefault();
      act(step());
    };
    document.addEventListener("keydown", onKey);
    return () => document.removeEventListener("keydown", onKey);
  }, [isOver]);
  const words = {
    none: "",
    starting: "Starting",
    running: "Running",
    paused: text,
    ended: text,
    replaced: "Another page debugs this run.",
    lost: "The connection is lost, and is being opened again. The run ends if this takes longer than a minute.",
  };
  return (
    <section class="panel debug" aria-label="Debugger">
      <div class="head">
        <h2>Debugger</h2>
        <span class="count" role="status">
          {words[status]}
        </span>
      </div>
      <div class="steps" role="toolbar" aria-label="Steps">
        <button type="button" class="primary" disabled={!isPaused} title="F5" onClick={() => act(debugSession.resume())}>
          ▶ Continue
        </button>
        <button type="button" disabled={status !== "running"} title="F6" onClick={() => act(debugSession.pause())}>
          ❚❚ Pause
        </button>
        {STEPS.map(([name, label, key]) => (
          <button key={name} type="button" disabled={!isPaused} title={key} onClick={() => act(debugSession.step(name as StepName))}>
            {label}
          </button>
        ))}
        <button type="button" class="danger" disabled={isOver} onClick={() => act(debugSession.stop())}>
          ■ End
        </button>
      </div>
      {problem !== null && <Problem error={problem} />}
      <div class="columns">
        <Branches branches={isPaused ? branches : []} isPaused={isPaused} frame={frame} onChoose={setFrame} state={state} />
        <FrameVariables frame={isPaused ? frame : null} />
      </div>
      <Breakpoints state={state} />
      <Console frame={isPaused ? frame : null} />
    </section>
  );
}

interface BranchesProps {
  branches: Branch[];
  isPaused: boolean;
  frame: StackFrame | null;
  onChoose: (frame: StackFrame) => void;
  state: PageState;
}

function Branches({ branches, isPaused, frame, onChoose, state }: BranchesProps) {
  return (
    <div>
      <h3>{isPaused ? plural(branches.length, "branch", "branches") : "Branches"}</h3>
      {!isPaused && <p class="muted">Pause the run to see its branches.</p>}
      <ul class="branches">
        {branches.map((branch) => (
          <li key={branch.id}>
            <bdi class="path">{clip(plain(branch.name), 160)}</bdi>
            {branch.activity && <div class="muted">{clip(plain(branch.activity), 300)}</div>}
            <ol>
              {branch.frames.map((each) => (
                <li key={each.id}>
                  <button type="button" class="cause" aria-pressed={each === frame} onClick={() => onChoose(each)}>
                    <bdi>{clip(plain(each.name), 120)}</bdi>
                  </button>{" "}
                  {each.source && <Place source={`${each.source.name}:${each.line}:1`} state={state} />}
                </li>
              ))}
            </ol>
          </li>
        ))}
      </ul>
    </div>
  );
}

function FrameVariables({ frame }: { frame: StackFrame | null }) {
  const [groups, setGroups] = useState<Group[]>([]);
  useEffect(() => {
    let isCurrent = true;
    setGroups([]);
    if (frame === null) return;
    readGroups(frame.id).then(
      (found) => isCurrent && setGroups(found.filter((group) => group.name !== "Activity")),
      () => undefined, // the run goes on
    );
    return () => {
      isCurrent = false;
    };
  }, [frame]);
  return (
    <div>
      <h3>Variables</h3>
      {frame === null && <p class="muted">Pause the run to see its variables.</p>}
      {groups.map((group) => (
        <div key={group.name} class="group">
          <h4>
            <bdi>{clip(plain(group.name), 120)}</bdi>
          </h4>
          <Variables variables={group.variables} />
        </div>
      ))}
    </div>
  );
}

function Console({ frame }: { frame: StackFrame | null }) {
  const output = useCell(debugSession.output);
  const [expression, setExpression] = useState("");
  const [result, setResult] = useState("");
  const evaluate = async (event: Event) => {
    event.preventDefault();
    if (expression.trim() === "") return;
    try {
      setResult(`${expression} = ${await debugSession.evaluate(expression, frame?.id ?? null)}`);
    } catch (error) {
      setResult(error instanceof Error ? error.message : String(error));
    }
  };
  return (
    <details>
      <summary>Console</summary>
      <pre class="output" tabIndex={0} aria-label="Output of the run">
        {output.length === 0 ? "No output yet." : output.map(plain).join("\n")}
      </pre>
      <form class="tools" onSubmit={(event) => void evaluate(event)}>
        <label class="search wide">
          <span class="name">expression</span>{" "}
          <input value={expression} disabled={frame === null} onInput={(event) => setExpression(event.currentTarget.value)} />
        </label>
        <button type="submit" disabled={frame === null}>
          Evaluate
        </button>
        <output>{clip(plain(result), 1000)}</output>
      </form>
    </details>
  );
}
