// Parameters, variables at the chosen time, margins and measurements.
import type { RunModel } from "../data/model";
import type { Json, TraceRecord } from "../data/types";
import { after } from "../data/unpack";
import { useCell, useRevision } from "../state";
import { clip, digits, plain, seconds, shown } from "../text";
import type { ViewProps } from "./RunViews";
import { Place } from "./Place";

const MOST = 500; // rows of a table

export function Values({ run, state }: ViewProps) {
  const time = useCell(state.time);
  useRevision(run);
  const parameters = Object.entries(run.meta.start?.parameters ?? {});
  const variables = run.series.filter((series) => series.kind === "variable");
  const { margins, measurements } = run.meta;
  const robots = measured(measurements);
  if (parameters.length + variables.length + margins.length + robots.length === 0) {
    return <p class="empty">The scenario has no parameters and variables, and nothing was measured.</p>;
  }
  return (
    <div class="values scrolls" tabIndex={0} role="region" aria-label="Values">
      {parameters.length > 0 && (
        <Table title="Parameters" rows={parameters.map(([name, value]) => [name, shown(value)])} />
      )}
      {variables.length > 0 && (
        <Table
          title={`Variables at ${seconds(time)}`}
          rows={variables.slice(0, MOST).map((series) => [series.name, valueAt(series.times, series.values, time)])}
        />
      )}
      {margins.length > 0 && <Margins margins={margins} state={state} />}
      {robots.map(([name, rows]) => (
        <Table key={name} title={`Measured: ${name}`} rows={rows} />
      ))}
    </div>
  );
}

function valueAt(times: Float64Array, values: Float64Array, time: number): string {
  const index = after(times, time + 1e-9) - 1;
  return index < 0 ? "not changed yet" : digits(values[index]!, 6);
}

function Table({ title, rows }: { title: string; rows: [string, string][] }) {
  return (
    <table>
      <caption>{clip(plain(title), 200)}</caption>
      <tbody>
        {rows.map(([name, value]) => (
          <tr key={name}>
            <th scope="row">
              <bdi>{clip(plain(name), 200)}</bdi>
            </th>
            <td>
              <bdi>{clip(plain(value), 500)}</bdi>
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Margins({ margins, state }: { margins: TraceRecord[]; state: ViewProps["state"] }) {
  const sorted = [...margins].sort((a, b) => Number(a["value"]) - Number(b["value"])).slice(0, MOST);
  return (
    <table>
      <caption>Margins of checks, the least first (0: the limit, below: failed)</caption>
      <thead>
        <tr>
          <th scope="col">check</th>
          <th scope="col">margin</th>
          <th scope="col">distance to the limit</th>
          <th scope="col">limit</th>
          <th scope="col">place</th>
        </tr>
      </thead>
      <tbody>
        {sorted.map((margin) => (
          <tr key={margin.seq}>
            <th scope="row">{clip(plain(shown(margin["check"])), 100)}</th>
            <td class={Number(margin["value"]) <= 0 ? "failed" : ""}>{digits(Number(margin["value"]))}</td>
            <td>{digits(Number(margin["distance"]))}</td>
            <td>{digits(Number(margin["limit"]))}</td>
            <td>
              <Place source={shown(margin["source"] ?? "")} state={state} />
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

const UNITS: Record<string, string> = {
  path_length: "m",
  driving_time: "s",
  localisation_error: "m",
  localisation_error_driving: "m",
  localisation_error_max: "m",
  localisation_deviation: "m",
  closest_approach: "m",
  max_speed: "m/s",
  mean_speed: "m/s",
  energy: "J",
  work: "J",
};

/** Measurements of robots and entities: name, and rows of a table. */
function measured(found: RunModel["meta"]["measurements"]): [string, [string, string][]][] {
  return ["robots", "entities"].flatMap((group) =>
    Object.entries(fieldsOf(found[group])).map(([name, values]): [string, [string, string][]] => [
      name,
      Object.entries(fieldsOf(values)).flatMap(([key, value]) => rowOf(key, value)),
    ]),
  );
}

function rowOf(key: string, value: Json): [string, string][] {
  if (value === null || (typeof value === "object" && Object.keys(value).length === 0)) return [];
  const text = typeof value === "number" ? digits(value, 4) : shown(value);
  return [[key.replaceAll("_", " "), UNITS[key] === undefined ? text : `${text} ${UNITS[key]}`]];
}

function fieldsOf(value: Json | undefined): { [name: string]: Json } {
  return value !== null && typeof value === "object" && !Array.isArray(value) ? value : {};
}
