// A list of lines of equal height, of which only the visible ones are in the page.
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";

const HEIGHT = 24; // [px] of a line
const MORE = 8; // lines above and below
const TALLEST = 8_000_000; // [px]; browsers limit the height of elements

interface Props {
  count: number;
  label: string;
  /** Line to bring into view when it changes. */
  focus: number;
  line: (index: number) => ComponentChildren;
  onChoose: (index: number) => void;
  wide?: boolean;
  /** Called for other keys than those of the list. */
  onOtherKey?: ((key: string, active: number) => void) | undefined;
}

export function VirtualList({ count, label, focus, line, onChoose, wide, onOtherKey }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const [top, setTop] = useState(0);
  const [height, setHeight] = useState(400);
  const [active, setActive] = useState(Math.max(focus, 0));
  const total = Math.min(count * HEIGHT, TALLEST);
  const reach = Math.max(total - height, 1);
  const rows = Math.ceil(height / HEIGHT);
  // Beyond the tallest element, lines are found by the share of the scrolled height.
  const first = total < TALLEST ? Math.floor(top / HEIGHT) : Math.round((top / reach) * (count - rows));
  const shift = total < TALLEST ? first * HEIGHT : top;

  useLayoutEffect(() => {
    const element = box.current!;
    const observer = new ResizeObserver(() => setHeight(element.clientHeight));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  const bring = (index: number) => {
    const element = box.current!;
    const visible = Math.floor(element.clientHeight / HEIGHT);
    const now = total < TALLEST ? Math.floor(element.scrollTop / HEIGHT) : first;
    if (index >= now + 1 && index < now + visible - 1) return;
    const wanted = Math.max(0, index - Math.floor(visible / 3));
    element.scrollTop = total < TALLEST ? wanted * HEIGHT : (wanted / Math.max(count - visible, 1)) * reach;
  };
  useEffect(() => {
    if (focus < 0) return;
    setActive(focus);
    bring(focus);
  }, [focus, count]);

  const onKey = (event: KeyboardEvent) => {
    const moves: Record<string, number> = {
      ArrowDown: active + 1,
      ArrowUp: active - 1,
      PageDown: active + rows - 1,
      PageUp: active - rows + 1,
      Home: 0,
      End: count - 1,
    };
    const next = moves[event.key];
    if (next !== undefined) {
      event.preventDefault();
      const index = Math.max(0, Math.min(count - 1, next));
      setActive(index);
      bring(index);
    } else if (event.key === "Enter") {
      event.preventDefault();
      onChoose(active);
    } else onOtherKey?.(event.key, active);
  };
  const from = Math.max(0, first - MORE);
  const to = Math.min(count, first + rows + MORE);
  const lines = [];
  for (let index = from; index < to; index++) {
    lines.push(
      <div
        role="option"
        key={index}
        id={`${label}-${index}`}
        aria-selected={index === active}
        aria-setsize={count}
        aria-posinset={index + 1}
        class={index === active ? "line active" : "line"}
        onClick={() => {
          setActive(index);
          onChoose(index);
        }}
      >
        {line(index)}
      </div>,
    );
  }
  const isActiveShown = active >= from && active < to;
  return (
    <div
      ref={box}
      class={wide ? "list wide" : "list"}
      role="listbox"
      tabIndex={0}
      aria-label={label}
      {...(isActiveShown ? { "aria-activedescendant": `${label}-${active}` } : {})}
      onScroll={(event) => setTop(event.currentTarget.scrollTop)}
      onKeyDown={onKey}
    >
      <div role="presentation" style={{ height: `${total}px` }}>
        <div role="presentation" class="lines" style={{ transform: `translateY(${shift - (first - from) * HEIGHT}px)` }}>
          {lines}
        </div>
      </div>
    </div>
  );
}
