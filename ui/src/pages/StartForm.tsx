// Form of a scenario: its parameters, and where and how it runs.
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { navigate, runPath } from "../app/router";
import type { Shared } from "../app/stores";
import { debugSession } from "../debug/session";
import { post, RequestFailed } from "../net/api";
import { clip, digits, plain } from "../text";
import { bodyOf, type Entry, fieldNamed, fieldOf, type Parameter, problemsOf, type ScenarioForm, type Settings } from "./start_data";

interface Props {
  entry: Entry;
  form: ScenarioForm;
  shared: Shared;
}

export function StartForm({ entry, form, shared }: Props) {
  const executors = shared.site.places.filter((place) => place.kind === "executor");
  const simulators = shared.site.simulators.filter((name) => !form.simulators?.length || form.simulators.includes(name));
  const [settings, setSettings] = useState<Settings>({
    ...{ place: executors[0]?.name ?? "", world: "", rate: "", seed: "", timeout: "", set: {} },
    simulator: form.needsSimulator && !form.simulators?.length ? (simulators[0] ?? "") : "",
  });
  const [problems, setProblems] = useState<{ [field: string]: string }>({});
  const [failure, setFailure] = useState<unknown>(null);
  const [isBusy, setIsBusy] = useState(false);
  const hasSimulator = settings.simulator !== "" || Boolean(form.simulators?.length);
  const change = (part: Partial<Settings>) => setSettings({ ...settings, ...part });
  const begin = async (isDebugged: boolean) => {
    const found = problemsOf(settings, form);
    setProblems(found);
    setFailure(null);
    if (Object.keys(found).length > 0) return focusFirst(found);
    setIsBusy(true);
    try {
      const body = bodyOf(entry.file, entry.name, settings);
      const { run } = isDebugged ? await debugSession.launch(body) : await post<{ run: string }>("/api/start", body);
      navigate(runPath(run));
    } catch (error) {
      setIsBusy(false);
      if (error instanceof RequestFailed && error.field !== "") {
        const fields = { [fieldNamed(error.field, form)]: [error.message, error.help].filter(Boolean).join(": ") };
        setProblems(fields);
        if (!focusFirst(fields)) setFailure(error);
      } else setFailure(error);
    }
  };
  const text = (field: "world" | "rate" | "seed" | "timeout", label: string, hint: string, given = "") => (
    <Field id={field} label={label} hint={hint} problem={problems[field]}>
      <input
        {...input(field, problems[field])}
        value={settings[field]}
        placeholder={clip(plain(given), 200)}
        maxLength={500}
        onInput={(event) => change({ [field]: event.currentTarget.value })}
      />
    </Field>
  );
  return (
    <form
      class="start-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        void begin(false);
      }}
    >
      {entry.doc && <p>{clip(plain(entry.doc), 1000)}</p>}
      <fieldset>
        <legend>Parameters</legend>
        {form.parameters.length === 0 && <p class="muted">The scenario has no parameters.</p>}
        {form.parameters.map((parameter) => (
          <ParameterField
            key={parameter.path}
            parameter={parameter}
            value={settings.set[parameter.path] ?? ""}
            problem={problems[fieldOf(parameter.path)]}
            onChange={(value) => change({ set: { ...settings.set, [parameter.path]: value } })}
          />
        ))}
      </fieldset>
      <fieldset>
        <legend>Run</legend>
        {executors.length > 1 && (
          <Field id="place" label="Place" hint="" problem={problems["place"]}>
            <select {...input("place", problems["place"])} value={settings.place} onChange={(event) => change({ place: event.currentTarget.value })}>
              {executors.map((place) => (
                <option key={place.name}>{place.name}</option>
              ))}
            </select>
          </Field>
        )}
        <Field id="simulator" label="Simulator" hint={form.needsSimulator ? "The scenario has robots." : ""} problem={problems["simulator"]}>
          <select
            {...input("simulator", problems["simulator"])}
            value={settings.simulator}
            onChange={(event) => change({ simulator: event.currentTarget.value })}
          >
            <option value="">{form.simulators?.length ? `default: ${form.simulators[0]}` : "none: real clock"}</option>
            {simulators.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </Field>
        {hasSimulator && text("world", "World", "Name or file.", form.world)}
        {hasSimulator && text("rate", "Rate", "1 is real time; max is as fast as possible.", "1")}
        {text("seed", "Seed", "The same seed repeats a run.", String(form.seed ?? "at random"))}
        {text("timeout", "Time limit [s]", "", String(form.timeout ?? "none"))}
      </fieldset>
      {failure !== null && <Problem error={failure} />}
      <div class="actions">
        <button type="button" disabled={isBusy || !shared.site.mayStart || !shared.site.mayDebug} onClick={() => void begin(true)}>
          Debug
        </button>
        <button type="submit" class="primary" disabled={isBusy || !shared.site.mayStart}>
          {isBusy ? "Starting…" : "Start"}
        </button>
      </div>
    </form>
  );
}

/** Attributes of an input that belong to its field. */
function input(field: string, problem: string | undefined) {
  const described = problem === undefined ? `${field}-hint` : `${field}-problem ${field}-hint`;
  return { id: `field-${field}`, "aria-describedby": described, ...(problem === undefined ? {} : { "aria-invalid": true }) };
}

interface FieldProps {
  id: string;
  label: ComponentChildren;
  hint: string;
  problem: string | undefined;
  children: ComponentChildren;
}

function Field({ id, label, hint, problem, children }: FieldProps) {
  return (
    <div class="field">
      <label for={`field-${id}`}>{label}</label>
      {children}
      {problem !== undefined && (
        <span class="field-problem" id={`${id}-problem`} role="alert">
          <span aria-hidden="true">✗ </span>
          {clip(plain(problem), 600)}
        </span>
      )}
      <span class="hint" id={`${id}-hint`}>
        {hint}
      </span>
    </div>
  );
}

interface ParameterProps {
  parameter: Parameter;
  value: string;
  problem: string | undefined;
  onChange: (value: string) => void;
}

function ParameterField({ parameter, value, problem, onChange }: ParameterProps) {
  const { path, type, unit, doc, choices } = parameter;
  const given = parameter.default ?? "";
  const field = fieldOf(path);
  const options = choices?.length ? choices : null;
  const label = (
    <>
      <bdi>{clip(plain(path), 100)}</bdi>
      <span class="muted">
        {" "}
        {clip(plain(type), 60)}
        {unit ? ` [${clip(plain(unit), 30)}]` : ""}
        {parameter.required && <strong> needed</strong>}
      </span>
    </>
  );
  return (
    <Field id={field} label={label} hint={[clip(plain(doc ?? ""), 300), rangeOf(parameter)].filter(Boolean).join(" ")} problem={problem}>
      {options === null ? (
        <input
          {...input(field, problem)}
          value={value}
          placeholder={given === "" && !parameter.required ? "chosen by the run" : clip(plain(given), 200)}
          maxLength={2000}
          spellcheck={false}
          onInput={(event) => onChange(event.currentTarget.value)}
        />
      ) : (
        <select {...input(field, problem)} value={value} onChange={(event) => onChange(event.currentTarget.value)}>
          <option value="">{given === "" ? (parameter.required ? "choose…" : "chosen by the run") : `default: ${clip(plain(given), 80)}`}</option>
          {options.map((option) => (
            <option key={option} value={option}>
              {clip(plain(option), 80)}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

function rangeOf({ minimum, maximum, unit }: Parameter): string {
  const size = unit ? ` ${clip(plain(unit), 30)}` : "";
  const [least, most] = [minimum, maximum].map((bound) => (typeof bound === "number" ? digits(bound, 6) : ""));
  if (!least && !most) return "";
  if (!least) return `At most ${most}${size}.`;
  return most ? `From ${least} to ${most}${size}.` : `At least ${least}${size}.`;
}

/** Put the focus on the first field with an error; false if none of them is in the form. */
function focusFirst(problems: { [field: string]: string }): boolean {
  for (const field of Object.keys(problems)) {
    const element = document.getElementById(`field-${field}`);
    if (element === null) continue;
    setTimeout(() => element.focus());
    return true;
  }
  return false;
}
