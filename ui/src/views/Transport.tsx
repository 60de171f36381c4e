// The time that all views show: slider, play, steps.
import { useEffect, useState } from "preact/hooks";
import type { RunModel } from "../data/model";
import { type PageState, useCell, useRevision } from "../state";
import { seconds } from "../text";
import type { ViewProps } from "./RunViews";

const RATES = [0.1, 0.5, 1, 2, 5, 10, 50];
const STEPS = 10_000; // of the slider

export function Transport({ run, state }: ViewProps) {
  const time = useCell(state.time);
  const isPlaying = useCell(state.isPlaying);
  const rate = useCell(state.rate);
  useRevision(run);
  const isFollowing = useCell(state.isFollowing);
  const end = run.end || 1;
  const set = (value: number) => {
    state.show(Math.max(0, Math.min(run.end, value)));
  };
  return (
    <section class="panel transport" aria-label="Time">
      <button type="button" aria-label={isPlaying ? "Pause" : "Play"} onClick={() => togglePlaying(run, state)}>
        <span aria-hidden="true">{isPlaying ? "❚❚" : "▶"}</span>
      </button>
      <input
        type="range"
        id="time"
        aria-label="Time of the run"
        aria-valuetext={seconds(time)}
        min={0}
        max={STEPS}
        step={1}
        value={Math.round((time / end) * STEPS)}
        onInput={(event) => set((Number(event.currentTarget.value) / STEPS) * end)}
      />
      <TimeField time={time} set={set} hold={() => follow(run, state, false)} />
      {run.isActive && (
        <button type="button" class="follow" aria-pressed={isFollowing} onClick={() => follow(run, state, !isFollowing)}>
          {isFollowing ? "● Live" : "○ Go live"}
        </button>
      )}
      <label class="rate">
        <span class="name">rate</span>
        <select value={String(rate)} onChange={(event) => (state.rate.value = Number(event.currentTarget.value))}>
          {RATES.map((value) => (
            <option key={value} value={String(value)}>
              {value}×
            </option>
          ))}
        </select>
      </label>
    </section>
  );
}

interface TimeProps {
  time: number;
  set: (value: number) => void;
  /** Let the time stand still while it is edited. */
  hold: () => void;
}

function TimeField({ time, set, hold }: TimeProps) {
  const [text, setText] = useState<string | null>(null);
  useEffect(() => setText(null), [time]);
  const commit = () => {
    const value = Number.parseFloat(text ?? "");
    if (Number.isFinite(value)) set(value);
    setText(null);
  };
  return (
    <label class="now">
      <input
        inputMode="decimal"
        aria-label="Time in seconds"
        value={text ?? time.toFixed(3)}
        onInput={(event) => {
          hold();
          setText(event.currentTarget.value);
        }}
        onBlur={() => text !== null && commit()}
        onKeyDown={(event) => event.key === "Enter" && commit()}
      />{" "}
      s
    </label>
  );
}

/** Keep the time at the end of a run that grows, or stop that. */
export function follow(run: RunModel, state: PageState, isFollowing: boolean): void {
  state.isPlaying.value = false;
  if (isFollowing) state.time.value = run.end;
  state.isFollowing.value = isFollowing;
}

export function togglePlaying(run: RunModel, state: PageState): void {
  if (!state.isPlaying.value && state.time.value >= run.end) state.time.value = 0;
  state.isFollowing.value = false;
  state.isPlaying.value = !state.isPlaying.value;
}

/** Advance the time while the page plays; keys of the page. Returns a function that stops this. */
export function startPlaying(run: RunModel, state: PageState): () => void {
  let last = 0;
  let frame = 0;
  const step = (now: number) => {
    const passed = Math.min((now - last) / 1000, 0.1) * state.rate.value;
    last = now;
    state.time.value = Math.min(run.end, state.time.value + passed);
    if (state.time.value >= run.end) {
      state.isPlaying.value = false;
      state.isFollowing.value = run.isActive; // playing has caught up
    }
    if (state.isPlaying.value) frame = requestAnimationFrame(step);
  };
  const stop = state.isPlaying.subscribe((isPlaying) => {
    cancelAnimationFrame(frame);
    last = performance.now();
    if (isPlaying) frame = requestAnimationFrame(step);
  });
  const onKey = (event: KeyboardEvent) => {
    const target = event.target as HTMLElement;
    const isControl = target.closest("button, input, select, textarea, [role=tab], a") !== null;
    if (event.key !== " " || isControl || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    togglePlaying(run, state);
  };
  document.addEventListener("keydown", onKey);
  return () => {
    stop();
    cancelAnimationFrame(frame);
    document.removeEventListener("keydown", onKey);
  };
}
