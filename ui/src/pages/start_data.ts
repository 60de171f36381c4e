// Data of the form that starts a run.

export interface Entry {
  file: string;
  name: string;
  /** Comment above the scenario. */
  doc?: string;
  line?: number;
  problem?: string;
}

export interface Parameter {
  path: string;
  type: string;
  unit?: string;
  /** Expression of the language; empty without one. */
  default?: string;
  doc?: string;
  choices?: string[] | null;
  /** Bounds in the unit; null without one. */
  minimum?: number | null;
  maximum?: number | null;
  required?: boolean;
}

export interface ScenarioForm {
  parameters: Parameter[];
  needsSimulator: boolean;
  /** Simulators that its file names; empty for any. */
  simulators?: string[];
  robots: string[];
  /** Settings of its file. */
  world?: string;
  seed?: number | null;
  timeout?: number | null;
  problem?: string;
}

/** Settings of a run, as texts of the form. */
export interface Settings {
  place: string;
  simulator: string;
  world: string;
  rate: string;
  seed: string;
  timeout: string;
  set: { [path: string]: string };
}

/** Check the settings; returns errors by field. */
export function problemsOf(settings: Settings, form: ScenarioForm): { [field: string]: string } {
  const found: { [field: string]: string } = {};
  for (const { path, required } of form.parameters) {
    if (required && !settings.set[path]?.trim()) found[fieldOf(path)] = "a value is needed: there is no default";
  }
  if (settings.seed !== "" && !/^\d{1,15}$/.test(settings.seed)) found["seed"] = "expected a whole number, such as 7";
  if (!isNumber(settings.rate) && !["", "max"].includes(settings.rate)) found["rate"] = "expected a number above 0, or max";
  if (!isNumber(settings.timeout) && settings.timeout !== "") found["timeout"] = "expected a number of seconds above 0";
  return found;
}

/** Field of a parameter in the form; those of the settings have their names. */
export function fieldOf(path: string): string {
  return `set.${path}`;
}

/** Field that the server names: the path of a parameter, or the name of a setting. */
export function fieldNamed(name: string, form: ScenarioForm): string {
  return form.parameters.some(({ path }) => path === name) ? fieldOf(name) : name;
}

function isNumber(text: string): boolean {
  return Number(text) > 0 && Number.isFinite(Number(text));
}

/** Body of the request, without what was left empty. */
export function bodyOf(file: string, scenario: string, settings: Settings): object {
  const { seed, timeout, set, ...others } = settings;
  const { rate, ...texts } = others;
  const filled = Object.entries(texts).filter(([, value]) => value !== "");
  return {
    ...{ file, scenario, set: Object.fromEntries(Object.entries(set).filter(([, value]) => value.trim() !== "")) },
    ...Object.fromEntries(filled),
    ...(seed === "" ? {} : { seed: Number(seed) }),
    ...(rate === "" ? {} : { rate: rate === "max" ? "max" : Number(rate) }),
    ...(timeout === "" ? {} : { timeout: Number(timeout) }),
  };
}
