// What the reader of the page has chosen: the time, a record, a row. Views subscribe to it.
import { useEffect, useState } from "preact/hooks";

/** A value that views follow. */
export class Cell<T> {
  private readonly listeners = new Set<(value: T) => void>();

  constructor(private current: T) {}

  get value(): T {
    return this.current;
  }

  set value(value: T) {
    if (value === this.current) return;
    this.current = value;
    for (const listener of [...this.listeners]) listener(value);
  }

  subscribe(listener: (value: T) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/** Follow a cell in a component. */
export function useCell<T>(cell: Cell<T>): T {
  const [value, setValue] = useState(cell.value);
  useEffect(() => {
    setValue(() => cell.value);
    return cell.subscribe((found) => setValue(() => found));
  }, [cell]);
  return value;
}

const READABLE = 100; // [ms] between changes of texts

/** Number of frames of a run, at most every `pause` milliseconds: for texts, which nobody reads more often. */
export function useRevision({ revision }: { revision: Cell<number> }, pause = READABLE): number {
  const [value, setValue] = useState(revision.value);
  useEffect(() => {
    let timer: ReturnType<typeof setTimeout> | undefined;
    const later = () => {
      timer ??= setTimeout(() => {
        timer = undefined;
        setValue(revision.value);
      }, pause);
    };
    setValue(revision.value);
    const stop = revision.subscribe(later);
    return () => {
      stop();
      clearTimeout(timer);
    };
  }, [revision, pause]);
  return value;
}

/** Marks at lines of the source, such as breakpoints. */
export interface LineMarks {
  /** Signs by place, `file:line`; their keys are the marked places. */
  marks: Cell<ReadonlyMap<string, string>>;
  /** Place at which the run is paused, `file:line`. */
  paused: Cell<string>;
  toggle: (file: string, line: number) => void;
}

export const TABS = ["Source", "Log", "Records", "Plots", "Values", "Coverage"] as const;
export type Tab = (typeof TABS)[number];

/** State of the page. */
export class PageState {
  /** Time that all views show [s]. */
  readonly time: Cell<number>;
  /** Number of the chosen record. */
  readonly record = new Cell<number | null>(null);
  readonly isPlaying = new Cell(false);
  /** Simulated seconds per second of playing. */
  readonly rate = new Cell(1);
  readonly tab = new Cell<Tab>("Source");
  /** Place in the scenario to show. */
  readonly place = new Cell("");

  /** Marks at lines of the source; null without a debugger. */
  lines: LineMarks | null = null;
  /** Whether the time stays at the end of a run that grows. */
  readonly isFollowing: Cell<boolean>;

  constructor(time: number, isFollowing = false) {
    this.time = new Cell(time);
    this.isFollowing = new Cell(isFollowing);
  }

  /** Show a time that the reader chose [s]. */
  show(time: number): void {
    this.isFollowing.value = false;
    this.time.value = time;
  }

  /** Show a place in the source. */
  showPlace(source: string): void {
    if (source === "") return;
    this.place.value = "";
    this.place.value = source;
    this.tab.value = "Source";
  }

  /** Choose a record and its time. */
  choose(seq: number, time: number): void {
    this.record.value = seq;
    this.show(time);
  }
}
