// The world in three dimensions, at the time that the page shows.
import type { RefObject } from "preact";
import { useEffect, useImperativeHandle, useRef, useState } from "preact/hooks";
import { loadSpace, type Picture } from "../space/loading";
import { useCell } from "../state";
import type { ViewProps } from "./RunViews";

export interface SpaceControl {
  zoom(factor: number): void;
  fit(): void;
}

interface Props extends ViewProps {
  map: HTMLCanvasElement | null;
  control: RefObject<SpaceControl>;
}

const STEP = 40; // [pixels] of a key

export function Space({ run, state, map, control }: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const picture = useRef<Picture | null>(null);
  const [problem, setProblem] = useState("");
  const revision = useCell(run.revision);
  const isGrown = run.tracks.tracks.length; // bodies of new entities need another picture

  const redraw = () => picture.current?.show(state.time.value);
  const change = (move: (shown: Picture) => void) => {
    if (picture.current === null) return;
    move(picture.current);
    redraw();
  };
  useImperativeHandle(control, () => ({
    zoom: (factor) => change((shown) => shown.zoom(factor)),
    fit: () => change((shown) => shown.fit()),
  }));
  useEffect(() => {
    let isOver = false;
    loadSpace()
      .then((make) => {
        if (isOver) return;
        picture.current = make(canvas.current!, run, map);
        resize();
      })
      .catch((error: unknown) => setProblem(error instanceof Error ? error.message : String(error)));
    const resize = () => {
      const box = canvas.current!.parentElement!;
      change((shown) => shown.resize(box.clientWidth, box.clientHeight));
    };
    const observer = new ResizeObserver(resize);
    observer.observe(canvas.current!.parentElement!);
    return () => {
      isOver = true;
      observer.disconnect();
      picture.current?.dispose();
      picture.current = null;
    };
  }, [run, map, run.meta.scene, isGrown]);
  useEffect(() => state.time.subscribe(redraw), [state]);
  useEffect(redraw, [revision]);

  const onKey = (event: KeyboardEvent) => {
    const keys: Record<string, (shown: Picture) => void> = {
      ArrowLeft: (shown) => shown.turn(-STEP, 0),
      ArrowRight: (shown) => shown.turn(STEP, 0),
      ArrowUp: (shown) => shown.turn(0, STEP),
      ArrowDown: (shown) => shown.turn(0, -STEP),
      "+": (shown) => shown.zoom(1.4),
      "-": (shown) => shown.zoom(1 / 1.4),
      "0": (shown) => shown.fit(),
    };
    const action = keys[event.key];
    if (action === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    change(action);
  };
  const onMove = (event: PointerEvent) => {
    if (event.buttons === 0) return;
    const isShift = event.buttons !== 1 || event.shiftKey;
    change((shown) => (isShift ? shown.shift(-event.movementX, event.movementY) : shown.turn(event.movementX, event.movementY)));
  };
  return (
    <>
      <canvas
        ref={canvas}
        class="space"
        tabIndex={0}
        role="img"
        aria-label="World in three dimensions. Arrows turn it, + and − zoom, 0 fits. The poses are listed below."
        onKeyDown={onKey}
        onContextMenu={(event) => event.preventDefault()}
        onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
        onPointerMove={onMove}
        onWheel={(event) => {
          if (!event.ctrlKey) return;
          event.preventDefault();
          change((shown) => shown.zoom(event.deltaY > 0 ? 0.85 : 1.18));
        }}
      />
      {problem !== "" && (
        <p class="empty" role="alert">
          The world cannot be shown in three dimensions: {problem}
        </p>
      )}
    </>
  );
}
