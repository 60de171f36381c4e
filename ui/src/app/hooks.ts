// Small hooks of pages.
import { useEffect, useState } from "preact/hooks";

/** Set the title of the document. */
export function useTitle(title: string): void {
  useEffect(() => {
    document.title = title === "" ? "seoro" : `${title} · seoro`;
  }, [title]);
}

/** Time of the machine, since 1970 [s]; it advances each second while it is needed. */
export function useNow(isNeeded: boolean): number {
  const [now, setNow] = useState(() => Date.now() / 1000);
  useEffect(() => {
    if (!isNeeded) return;
    setNow(Date.now() / 1000);
    const timer = setInterval(() => setNow(Date.now() / 1000), 1000);
    return () => clearInterval(timer);
  }, [isNeeded]);
  return now;
}

/** Whether the page is narrow. */
export function useNarrow(width: number): boolean {
  const query = `(max-width: ${width}px)`;
  const [isNarrow, setIsNarrow] = useState(() => matchMedia(query).matches);
  useEffect(() => {
    const found = matchMedia(query);
    const listener = () => setIsNarrow(found.matches);
    listener();
    found.addEventListener("change", listener);
    return () => found.removeEventListener("change", listener);
  }, [query]);
  return isNarrow;
}

/** Result of a request: data, or the error. Asked again when a key changes. */
export function useAnswer<T>(ask: () => Promise<T>, keys: unknown[]): { data: T | null; error: unknown; again: () => void } {
  const [found, setFound] = useState<{ data: T | null; error: unknown }>({ data: null, error: null });
  const [count, setCount] = useState(0);
  useEffect(() => {
    let isCurrent = true;
    ask().then(
      (data) => isCurrent && setFound({ data, error: null }),
      (error: unknown) => isCurrent && setFound({ data: null, error }),
    );
    return () => {
      isCurrent = false;
    };
  }, [...keys, count]);
  return { ...found, again: () => setCount(count + 1) };
}
