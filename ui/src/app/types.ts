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
  real: boolean;
  state: string;
  detail: string;
  stopped: boolean;
  holder: string;
  lease: string;
  /** End of the lease, since 1970 [s]. */
  until: number | null;
  queue: { who: string; since: number | null }[];
}

export interface LabMember {
  name: string;
  endpoint: string;
  kind: string;
  problem: string;
  robots: LabRobot[];
}

export interface Stopped {
  reason: string;
  by: string;
}

export interface LabState {
  members: LabMember[];
  stopped: Stopped | null;
}

export interface Outcome {
  name: string;
  error: string;
}

export type Counts = { [status: string]: number };

export interface Campaign {
  id: string;
  name: string;
  file: string;
  status: "running" | "paused" | "ended" | "interrupted";
  done: number;
  total: number | null;
  counts: Counts;
  started: number | null;
  ended: number | null;
}

export interface Bin {
  label: string;
  low?: number;
  high?: number;
  counts: Counts;
}

export interface CampaignState extends Campaign {
  rate: { value: number; low: number; high: number; confidence: number } | null;
  perSecond: number | null;
  timeLeft: number | null;
  axes: { name: string; unit: string; bins: Bin[] }[];
  failures: { number: number; run: string | null; status: string; reason: string; values: { [axis: string]: string } }[];
  coverage: { item: string; hit: number; total: number; grade: number }[];
  problem: string;
}
