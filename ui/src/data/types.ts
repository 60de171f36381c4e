// Data of a run, as `seoro.report` writes it.

/** A value of JSON. */
export type Json = null | boolean | number | string | Json[] | { [name: string]: Json };

/** A record of the trace. */
export interface TraceRecord {
  seq: number;
  t: number;
  kind: string;
  [field: string]: Json | undefined;
}

export interface RunStart extends TraceRecord {
  scenario: string;
  file: string;
  seed?: number;
  clock?: string;
  version?: string;
  parameters?: { [name: string]: Json };
  overrides?: { [name: string]: Json };
  requirements?: Json;
  robots?: Json;
}

export interface Value {
  text: string;
  value?: Json;
  unit?: string;
  shown?: string;
  error?: string;
}

export interface Emitter {
  text: string;
  source: string;
  last: number | null;
  after?: { text: string; source: string; path: string } | null;
}

export interface Activity {
  kind: string;
  text: string;
  source: string;
  path: string;
  since: number;
  due: number | null;
  values?: Value[];
  event?: string;
  emitters?: Emitter[];
}

export interface Explanation {
  t: number;
  path: string;
  values?: Value[];
  activities?: Activity[];
  more?: number;
}

export interface RunEnd {
  t: number;
  status: string;
  reason: string;
  source?: string;
  explanation?: Explanation | null;
  duration?: number;
  margin?: number | null;
  unobserved?: string[];
}

export interface SourceFile {
  name: string;
  sha256?: string;
  text?: string;
  library?: boolean;
}

export interface StaticBehavior {
  id: number;
  parent: number | null;
  scenario: string;
  type: string;
  name: string;
  source: string;
  source_end?: string;
}

export type Numbers7 = [number, number, number, number, number, number, number];

export interface Shape {
  entity?: string;
  kind: string;
  pose: number[];
  size: number[];
  /** Outline of a polygon. */
  points?: [number, number][];
  /** Corners of a hull, and its triangles. */
  corners?: [number, number, number][];
  triangles?: [number, number, number][];
  /** Link of a robot with which it moves. */
  link?: string;
  color?: string;
}

export interface SceneEntity {
  name: string;
  kind?: string;
  model?: string;
  real?: boolean;
  footprint?: [number, number][];
  height?: number;
  shapes?: Shape[];
  /** Times from which the poses are in a frame; without any, in the map. */
  frames?: [time: number, frame: string][];
  /** Poses of links in the posture of the shapes. */
  links?: { [name: string]: number[] };
}

export interface GridMap {
  resolution: number;
  origin: [number, number, number];
  width: number;
  height: number;
  data: string;
}

export interface Scene {
  world?: string | null;
  simulator?: string | null;
  extent?: [number, number, number, number];
  shapes?: Shape[];
  entities?: SceneEntity[];
  map?: GridMap;
  places?: { name: string; pose: [number, number, number] }[];
}

/** Row of the timeline: parent, type, name, path, source, end of the source, number in the static tree. */
export type RowData = [number, string, string, string, string, string, number];

export interface SeriesData {
  kind: string;
  name: string;
  unit: string;
}

export interface CoverageItem {
  item: string;
  kind: string;
  unit?: string;
  text?: string;
  target?: number;
  buckets: { [name: string]: number };
  total: number;
  grade: number;
}

/** First `seq`, first time [s], number of lines, and number of a block of records. */
export type BlockData = [number, number, number, number];

export interface Meta {
  start: RunStart | null;
  end: RunEnd | null;
  scene: Scene | null;
  sources: SourceFile[];
  tree: StaticBehavior[];
  time: number;
  count: number;
  kinds: string[];
  counts: { [kind: string]: number };
  statuses: string[];
  step: number;
  rows: RowData[];
  strings: string[];
  entities: { name: string }[];
  beams: number[][];
  links: [robot: string, link: string][];
  series: SeriesData[];
  blocks: BlockData[];
  layout: { [name: string]: [string, number] };
  margins: TraceRecord[];
  samples: TraceRecord[];
  notes: string[];
  command: string;
  measurements: { [name: string]: Json };
  coverage: { coverage?: CoverageItem[] };
  status?: string;
  /** Whether a frame has everything so far. */
  first?: boolean;
}
