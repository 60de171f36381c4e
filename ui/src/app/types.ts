// Data of the server; see `seoro/ui/`.

export interface Place {
  name: string;
  kind: "executor" | "folder";
  problem: string;
}

export interface Site {
  version: string;
  places: Place[];
  simulators: string[];
  hasLab: boolean;
  mayStart: boolean;
  /** Whether the user may start and stop runs, and command the lab. */
  mayAct: boolean;
  mayDebug: boolean;
  demo: boolean;
}

export type Status = "waiting" | "running" | "passed" | "failed" | "error" | "cancelled" | "killed";

export interface Run {
  id: string;
  place: string;
  kind: "executor" | "folder";
  scenario: string;
  file: string;
  status: Status;
  reason: string;
  /** Times since 1970 [s]. */
  submitted: number | null;
  started: number | null;
  ended: number | null;
  by: string;
  robots: string[];
  waits: string;
  position: number | null;
  mayStop: boolean;
  records?: number | null;
  folder?: string;
}

export interface LabRobot {
  name: string;
  type: string;
  /** Null if unknown. */
  real: boolean | null;
  state: string;
  detail: string;
  /** Text about its emergency stop; null without one. */
  stopped: string | null;
  holder: string;
  lease: string | null;
  /** End of the lease, since 1970 [s]. */
  until: number | null;
  queue: string[];
}

export interface LabMember {
  name: string;
  endpoint: string;
  kind: string;
  problem: string;
  /** Text about its emergency stop; empty without one. */
  stopped: string;
  robots: LabRobot[];
}

export interface Stopped {
  reason: string;
  by: string;
  since: number | null;
  /** Number of members that are stopped, and of all known ones. */
  count: number;
  of: number;
}

export interface LabState {
  members: LabMember[];
  stopped: Stopped | null;
}

export interface Outcome {
  name: string;
  error: string;
}

export interface Campaign {
  id: string;
  title: string;
  folder?: string;
  /** Time of the last change, since 1970 [s]. */
  changed?: number;
  /** `running`, `complete`, `stopped` or `ended`; missing if the campaign cannot be read. */
  status?: string;
  /** Planned number of runs; null without an end. */
  runs?: number | null;
  done?: number;
  counts?: { [status: string]: number };
  problem?: string;
}

/** Runs whose value of an axis is in a range, or is one value. */
export interface Bucket {
  label: string;
  passed: number;
  failed: number;
  rateLow: number | null;
  rateHigh: number | null;
}

export interface Axis {
  path: string;
  /** How much more pass rates differ than by chance, in standard deviations; null if unknown. */
  influence: number | null;
  buckets: Bucket[];
}

export interface CampaignFailure {
  run: number;
  status: string;
  reason: string;
  where: string;
  values: { [axis: string]: unknown };
  seed: number;
  /** ID of the run for its page; null if it was not kept. */
  kept: string | null;
}

export interface CampaignState extends Campaign {
  rate: { passed: number; failed: number; share: number | null; low: number | null; high: number | null; validity: string };
  stop: string | null;
  impossible: number;
  /** Whether rows are still to be read. */
  isReading: boolean;
  /** Runs per second. */
  pace: number | null;
  /** Time left [s]. */
  left: number | null;
  /** ISO text. */
  firstStart: string | null;
  simulator: string | null;
  strategy: string;
  seed: number;
  axes: Axis[];
  measurements: Axis[];
  groups: { reason: string; where: string; count: number; example: number }[];
  latest: CampaignFailure[];
  coverage: { item: string; unit: string; reached: number; reachable: number | null; holes: string[]; holeCount: number }[];
}
