// What all pages share: the site, its runs, and the state of its lab.
import { LiveSocket } from "../net/socket";
import { Cell } from "../state";
import type { LabState, Run, Site } from "./types";

/** All known runs, the latest first. */
export class RunStore {
  readonly runs = new Cell<readonly Run[] | null>(null);
  readonly socket: LiveSocket;
  private byId = new Map<string, Run>();

  constructor() {
    this.socket = new LiveSocket("/api/runs", (data) => this.take(JSON.parse(String(data))));
  }

  get(id: string): Run | undefined {
    return this.byId.get(id);
  }

  private take(message: { runs?: Run[]; changed?: Run[]; removed?: string[] }): void {
    if (message.runs) this.byId = new Map();
    for (const run of message.runs ?? message.changed ?? []) this.byId.set(run.id, run);
    for (const id of message.removed ?? []) this.byId.delete(id);
    this.runs.value = [...this.byId.values()].sort((a, b) => timeOf(b) - timeOf(a));
  }
}

function timeOf(run: Run): number {
  return run.submitted ?? run.started ?? run.ended ?? 0;
}

/** State of the lab, and whether an emergency stop is active. */
export class LabStore {
  readonly state = new Cell<LabState | null>(null);
  readonly socket = new LiveSocket("/api/lab", (data) => (this.state.value = JSON.parse(String(data)) as LabState));
}

export interface Shared {
  site: Site;
  runs: RunStore;
  lab: LabStore;
}
