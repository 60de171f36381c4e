// Pages by paths, without loading the document again.
import type { ComponentChildren } from "preact";
import { Cell } from "../state";

/** Path and query of the page. */
export const location_ = new Cell(location.pathname + location.search);
addEventListener("popstate", () => (location_.value = location.pathname + location.search));

/** Go to a page. */
export function navigate(path: string): void {
  if (path !== location_.value) history.pushState(null, "", path);
  location_.value = path;
  scrollTo(0, 0);
}

interface LinkProps {
  href: string;
  class?: string;
  current?: boolean;
  children: ComponentChildren;
}

/** Link to a page. */
export function Link({ href, class: name, current, children }: LinkProps) {
  const go = (event: MouseEvent) => {
    if (event.button !== 0 || event.metaKey || event.ctrlKey || event.shiftKey || event.altKey) return;
    event.preventDefault();
    navigate(href);
  };
  return (
    <a href={href} class={name} onClick={go} {...(current ? { "aria-current": "page" as const } : {})}>
      {children}
    </a>
  );
}

export function runPath(id: string): string {
  return `/run/${encodeURIComponent(id)}`;
}

export function campaignPath(id: string): string {
  return `/campaign/${encodeURIComponent(id)}`;
}
