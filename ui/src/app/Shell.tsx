// Frame of all pages: name, navigation, state of the connection, emergency stop.
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { SocketState } from "../net/socket";
import { useCell } from "../state";
import { clip, plain } from "../text";
import { EmergencyStop, StopBanner } from "./EmergencyStop";
import { Link, location_ } from "./router";
import type { Shared } from "./stores";

const AREAS: [path: string, name: string, others: RegExp][] = [
  ["/runs", "Runs", /^\/($|run\/|runs|compare)/],
  ["/start", "Start", /^\/start/],
  ["/lab", "Lab", /^\/lab/],
  ["/campaigns", "Campaigns", /^\/campaign/],
];

export function Shell({ shared, children }: { shared: Shared; children: ComponentChildren }) {
  const path = useCell(location_);
  const main = useRef<HTMLElement>(null);
  const page = path.split("?")[0]!;
  const isFirst = useRef(true);
  useEffect(() => {
    if (!isFirst.current) main.current?.focus({ preventScroll: true }); // for screen readers: the page changed
    isFirst.current = false;
  }, [page]);
  return (
    <>
      <a class="skip" href="#content">
        Skip to the content
      </a>
      <header class="top">
        <Link href="/runs" class="brand">
          seoro
        </Link>
        <nav aria-label="Pages">
          {AREAS.filter(([href]) => shared.site.mayAct || href !== "/start").map(([href, name, others]) => (
            <Link key={href} href={href} current={others.test(page)}>
              {name}
            </Link>
          ))}
        </nav>
        <Connection shared={shared} />
        {shared.site.mayAct ? <EmergencyStop lab={shared.lab} /> : <p class="watching">Watch only</p>}
      </header>
      <StopBanner lab={shared.lab} mayRelease={shared.site.mayAct} />
      <LostBanner shared={shared} />
      <main id="content" ref={main} tabIndex={-1}>
        {children}
      </main>
    </>
  );
}

const STATES: Record<SocketState, [sign: string, word: string]> = {
  connecting: ["◌", "Connecting"],
  open: ["●", "Connected"],
  lost: ["○", "Not connected"],
  refused: ["○", "Refused"],
};

function Connection({ shared }: { shared: Shared }) {
  const state = useCell(shared.runs.socket.state);
  const executors = shared.site.places.filter((place) => place.kind === "executor");
  const [sign, word] = STATES[state];
  return (
    <p class={`connection ${state}`} role="status">
      <span class="sign" aria-hidden="true">
        {sign}
      </span>{" "}
      {word}
      {state === "open" && executors[0] && !executors[0].problem && <span class="muted"> to {clip(plain(executors[0].name), 30)}</span>}
    </p>
  );
}

function LostBanner({ shared }: { shared: Shared }) {
  const state = useCell(shared.runs.socket.state);
  const refusal = useCell(shared.runs.socket.refusal);
  if (state === "refused") {
    return (
      <div class="banner" role="alert">
        <p>
          <strong>! {refusal?.error}.</strong> {refusal?.help}
        </p>
      </div>
    );
  }
  if (state !== "lost") return null;
  return (
    <div class="banner" role="alert">
      <p>
        <strong>! The connection is lost.</strong> What you see is old. It is opened again as soon as seoro ui answers; if that was
        ended, start it again and open the URL that it prints.
      </p>
    </div>
  );
}
