// The emergency stop: a button on every page, and a banner while it is active.
import { useState } from "preact/hooks";
import { post, textOf } from "../net/api";
import { useCell } from "../state";
import { clip, plain } from "../text";
import { Confirm } from "./Confirm";
import type { LabStore } from "./stores";
import type { Outcome } from "./types";

/** Stop everything at once, without a question. */
export function EmergencyStop({ lab }: { lab: LabStore }) {
  const state = useCell(lab.state);
  const [result, setResult] = useState<{ isGood: boolean; text: string } | null>(null);
  const [isBusy, setIsBusy] = useState(false);
  const stop = async () => {
    setIsBusy(true);
    setResult(null);
    try {
      setResult(summary((await post<{ outcomes: Outcome[] }>("/api/lab/stop-all", {})).outcomes));
    } catch (error) {
      setResult({ isGood: false, text: `Emergency stop failed: ${textOf(error).error}. Use the stop of the robots.` });
    }
    setIsBusy(false);
  };
  return (
    <>
      <button type="button" class="emergency" onClick={() => void stop()} aria-busy={isBusy}>
        <span class="octagon" aria-hidden="true" />
        {isBusy ? "Stopping…" : state?.stopped ? "Stop again" : "Emergency stop"}
      </button>
      <div role="alert" class="toasts">
        {result !== null && (
          <div class={result.isGood ? "toast" : "toast bad"}>
            <span>{result.text}</span>
            <button type="button" aria-label="Close the message" onClick={() => setResult(null)}>
              ×
            </button>
          </div>
        )}
      </div>
    </>
  );
}

function summary(outcomes: Outcome[]): { isGood: boolean; text: string } {
  const failed = outcomes.filter((outcome) => outcome.error !== "");
  if (failed.length > 0) {
    const names = failed.slice(0, 5).map((outcome) => `${clip(plain(outcome.name), 60)}: ${clip(plain(outcome.error), 120)}`);
    const more = failed.length > 5 ? `; ${failed.length - 5} more` : "";
    return { isGood: false, text: `Not stopped: ${names.join("; ")}${more}. Use the stop of the robots.` };
  }
  if (outcomes.length === 0) return { isGood: true, text: "Nothing was running." };
  return { isGood: true, text: `Stopped: ${outcomes.map((outcome) => clip(plain(outcome.name), 40)).slice(0, 8).join(", ")}` };
}

/** Banner while an emergency stop is active, with its release. */
export function StopBanner({ lab, mayRelease }: { lab: LabStore; mayRelease: boolean }) {
  const stopped = useCell(lab.state)?.stopped ?? null;
  const [isAsking, setIsAsking] = useState(false);
  if (stopped === null) return null;
  return (
    <div class="banner stopped" role="region" aria-label="Emergency stop">
      <p>
        <strong>
          <span class="octagon" aria-hidden="true" /> Emergency stop is active.
        </strong>{" "}
        {stopped.by && `By ${clip(plain(stopped.by), 80)}. `}
        {stopped.count < stopped.of && `${stopped.count} of ${stopped.of} members are stopped. `}
        {stopped.reason && <bdi>{clip(plain(stopped.reason), 200)}</bdi>}
      </p>
      {mayRelease && (
        <button type="button" onClick={() => setIsAsking(true)}>
          Release…
        </button>
      )}
      {isAsking && <ReleaseDialog onClose={() => setIsAsking(false)} />}
    </div>
  );
}

function ReleaseDialog({ onClose }: { onClose: () => void }) {
  return (
    <Confirm
      title="Release the emergency stop?"
      action="Release"
      ask="Why is it safe?"
      isDangerous
      onConfirm={async (reason) => failedOutcomes((await post<{ outcomes: Outcome[] }>("/api/lab/release", { reason })).outcomes)}
      onClose={onClose}
    >
      <p>Robots may move again as soon as a run commands them. Make sure that nobody is near them.</p>
    </Confirm>
  );
}

/** Raise an error that names what was not done. */
export function failedOutcomes(outcomes: Outcome[]): void {
  const failed = outcomes.filter((outcome) => outcome.error !== "");
  if (failed.length > 0) throw new Error(failed.map((outcome) => `${outcome.name}: ${outcome.error}`).join("; "));
}
