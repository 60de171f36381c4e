// Name of a row of the timeline.
import type { RunModel } from "../data/model";
import type { Row } from "../data/rows";
import { sourceText } from "../data/sentences";
import { clip, plain } from "../text";

interface LabelProps {
  row: Row;
  text: string;
  number: number;
  y: number;
  isActive: boolean;
  isFolded: boolean;
  onFold: () => void;
  onChoose: () => void;
}

const MARKS: [mark: string, status: string, words: string][] = [
  ["▸", "running", "not ended"],
  ["✓", "succeeded", "succeeded"],
  ["✗", "failed", "failed"],
  ["–", "cancelled", "cancelled"],
];

export function Label({ row, text, number, y, isActive, isFolded, onFold, onChoose }: LabelProps) {
  const worst = [2, 0, 3, 1].find((status) => row.counts[status as 0 | 1 | 2 | 3] > 0);
  const [mark, status, words] = worst === undefined ? ["○", "never", "never ran"] : MARKS[worst]!;
  const siblings = row.parent?.children ?? [];
  return (
    <div
      role="treeitem"
      id={`row-${number}`}
      class={isActive ? "label active" : "label"}
      style={{ top: `${y}px`, paddingLeft: `${4 + 12 * Math.min(row.depth, 14)}px` }}
      aria-level={row.depth + 1}
      aria-selected={isActive}
      {...(siblings.length > 0 ? { "aria-setsize": siblings.length, "aria-posinset": siblings.indexOf(row) + 1 } : {})}
      {...(row.children.length > 0 ? { "aria-expanded": !isFolded } : {})}
      title={plain(`${row.name}, ${row.type}: ${row.path} (${row.source})`).slice(0, 2000)}
      onClick={onChoose}
    >
      <span
        class="fold"
        aria-hidden="true"
        onClick={(event) => {
          event.stopPropagation();
          onFold();
        }}
      >
        {row.children.length === 0 ? "" : isFolded ? "▸" : "▾"}
      </span>
      <span class={`mark ${status}`} aria-hidden="true">
        {mark}
      </span>
      <bdi>{clip(plain(text), 120)}</bdi>
      <span class="hidden">
        , {row.type}, {words}
      </span>
      {row.runs.length > 1 && <span class="times">{row.runs.length.toLocaleString("en")}×</span>}
    </div>
  );
}

/** What a row is called: the text of waits and emissions, which all have the same name. */
export function labelOf(run: RunModel, row: Row): string {
  const isNamed = row.type !== "wait" && row.type !== "emit";
  return isNamed ? row.name : sourceText(run, row.source, row.sourceEnd) || row.name;
}
