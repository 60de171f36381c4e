// Variables as a tree; parts are read when they are opened.
import { useState } from "preact/hooks";
import { clip, plain } from "../text";
import { debugSession, type Variable } from "./session";

const MOST = 200;

export function Variables({ variables }: { variables: Variable[] }) {
  if (variables.length === 0) return <p class="muted">none</p>;
  return (
    <ul class="variables">
      {variables.slice(0, MOST).map((variable) => (
        <li key={variable.name}>
          {variable.variablesReference > 0 ? <Parts variable={variable} /> : <Line variable={variable} />}
        </li>
      ))}
      {variables.length > MOST && <li class="muted">{variables.length - MOST} more</li>}
    </ul>
  );
}

function Line({ variable }: { variable: Variable }) {
  return (
    <>
      <bdi class="path" title={variable.type}>
        {clip(plain(variable.name), 100)}
      </bdi>
      {" = "}
      <bdi class="value">{clip(plain(variable.value), 400)}</bdi>
    </>
  );
}

function Parts({ variable }: { variable: Variable }) {
  const [parts, setParts] = useState<Variable[] | null>(null);
  const open = (isOpen: boolean) => {
    if (!isOpen || parts !== null) return;
    debugSession.variables(variable.variablesReference).then(setParts, () => setParts([]));
  };
  return (
    <details onToggle={(event) => open(event.currentTarget.open)}>
      <summary>
        <Line variable={variable} />
      </summary>
      {parts !== null && <Variables variables={parts} />}
    </details>
  );
}
