// Colours of canvases: those of the style sheet, so that light and dark are the same everywhere.

export interface Theme {
  text: string;
  muted: string;
  line: string;
  surface: string;
  strong: string;
  cursor: string;
  chosen: string;
  status: [running: string, succeeded: string, failed: string, cancelled: string];
  wall: string;
  floor: string;
  unknown: string;
  entities: string[];
  font: string;
}

const DARK = matchMedia("(prefers-color-scheme: dark)");
let known: Theme | null = null;
DARK.addEventListener("change", () => (known = null)); // before other listeners, which draw

/** Colours of the page. They are read once: reading them makes the browser compute all styles anew. */
export function theme(): Theme {
  return (known ??= read());
}

function read(): Theme {
  const style = getComputedStyle(document.documentElement);
  const get = (name: string) => style.getPropertyValue(`--${name}`).trim();
  return {
    text: get("text"),
    muted: get("muted"),
    line: get("line"),
    surface: get("surface"),
    strong: get("strong"),
    cursor: get("cursor"),
    chosen: get("chosen"),
    status: [get("running"), get("succeeded"), get("failed"), get("cancelled")],
    wall: get("wall"),
    floor: get("floor"),
    unknown: get("unknown"),
    entities: [1, 2, 3, 4, 5, 6, 7].map((number) => get(`entity-${number}`)),
    font: "12px system-ui, sans-serif",
  };
}

/** Call a function when the system changes between light and dark; returns a function that stops this. */
export function onThemeChange(listener: () => void): () => void {
  DARK.addEventListener("change", listener);
  return () => DARK.removeEventListener("change", listener);
}

/** Make a canvas as sharp as the screen; returns its context, scaled to CSS pixels. */
export function prepare(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const scale = devicePixelRatio || 1;
  const [pixelsX, pixelsY] = [Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale))];
  if (canvas.width !== pixelsX || canvas.height !== pixelsY) {
    canvas.width = pixelsX;
    canvas.height = pixelsY;
  }
  const context = canvas.getContext("2d")!;
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/** Round steps for an axis with about `count` marks. */
export function niceStep(span: number, count: number): number {
  const raw = span / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw || 1));
  const factor = [1, 2, 5, 10].find((value) => value * power >= raw) ?? 10;
  return factor * power;
}
