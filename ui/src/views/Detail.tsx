// The chosen record: what it is, why it happened, and its fields.
import { useEffect, useState } from "preact/hooks";
import { type Cause, causes, placeOf, when } from "../data/sentences";
import { useCell } from "../state";
import { clip, plain, shown } from "../text";
import type { ViewProps } from "./RunViews";
import { Place } from "./Place";

const LONGEST = 4_000; // characters of a field
const SHOWN = 12; // causes, until the reader asks for all

export function Detail({ run, state }: ViewProps) {
  const seq = useCell(state.record);
  const [chain, setChain] = useState<Cause[]>([]);
  const [isWhole, setIsWhole] = useState(false);
  useEffect(() => {
    setIsWhole(false);
    if (seq === null) {
      setChain([]);
      return;
    }
    let isCurrent = true;
    void run.records
      .find(seq)
      .then((record) => (record === null ? [] : causes(run, record)))
      .then((found) => isCurrent && setChain(found));
    return () => {
      isCurrent = false;
    };
  }, [run, seq]);
  const [chosen, ...because] = chain;
  if (chosen === undefined) return null;
  const { record } = chosen;
  const fields = Object.entries(record).filter(([name]) => !["seq", "t", "kind", "cause"].includes(name));
  const visible = isWhole ? because : because.slice(0, SHOWN);
  return (
    <section class="panel detail" aria-label="Chosen record" aria-live="polite">
      <div class="head">
        <h2>
          {when(record)}: <bdi>{chosen.text}</bdi>
        </h2>
        <button type="button" aria-label="Close the chosen record" onClick={() => (state.record.value = null)}>
          ×
        </button>
      </div>
      <Place source={placeOf(run, record)} state={state} />
      <h3>Why</h3>
      {because.length === 0 ? (
        <p class="muted">
          {typeof record["cause"] === "number"
            ? "Its cause is not among the records of this report."
            : record.kind === "run.start"
              ? "Everything begins here."
              : "The trace has no cause of this record."}
        </p>
      ) : (
        <ol class="causes">
          {visible.map((cause) => (
            <li key={cause.record.seq}>
              <button type="button" class="cause" onClick={() => state.choose(cause.record.seq, cause.record.t)}>
                <span class="time">{when(cause.record)}</span> because <bdi>{cause.text}</bdi>
              </button>{" "}
              <Place source={placeOf(run, cause.record)} state={state} />
            </li>
          ))}
        </ol>
      )}
      {visible.length < because.length && (
        <button type="button" onClick={() => setIsWhole(true)}>
          Show {because.length - visible.length} earlier causes
        </button>
      )}
      <h3>Fields of record {record.seq}</h3>
      <dl class="fields">
        <dt>kind</dt>
        <dd>{plain(record.kind)}</dd>
        {fields.map(([name, value]) => [
          <dt key={`${name}-name`}>{clip(plain(name), 100)}</dt>,
          <dd key={name}>
            <bdi>{clip(plain(shown(value)), LONGEST)}</bdi>
          </dd>,
        ])}
      </dl>
    </section>
  );
}
