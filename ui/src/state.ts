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

  constructor(time: number) {
    this.time = new Cell(time);
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
    this.time.value = time;
  }
}
