// The lab: which robots are real, what they do, who holds them, who waits.
import { useState } from "preact/hooks";
import { Confirm, Problem } from "../app/Confirm";
import { failedOutcomes } from "../app/EmergencyStop";
import { useNow, useTitle } from "../app/hooks";
import type { Shared } from "../app/stores";
import type { LabMember, LabRobot, Outcome } from "../app/types";
import { rest } from "../app/words";
import { post } from "../net/api";
import { useCell } from "../state";
import { clip, plain, plural } from "../text";

/** What the reader wants to do with a robot. */
type Wish = { kind: "stop" | "lease" | "end-lease" | "release"; robot: LabRobot };

export function Lab({ shared }: { shared: Shared }) {
  useTitle("Lab");
  const lab = useCell(shared.lab.state);
  const socket = useCell(shared.lab.socket.state);
  const refusal = useCell(shared.lab.socket.refusal);
  const [wish, setWish] = useState<Wish | null>(null);
  const robots = lab?.members.flatMap((member) => member.robots) ?? [];
  const real = robots.filter((robot) => robot.real).length;
  return (
    <>
      <div class="title">
        <h1>Lab</h1>
        <span class="count" role="status">
          {lab && `${plural(robots.length, "robot")}, ${real} real`}
        </span>
      </div>
      {refusal !== null && <Problem error={new Error([refusal.error, refusal.help].filter(Boolean).join(": "))} />}
      {lab === null && refusal === null && (
        <section class="panel">
          <p class="empty">{socket === "lost" ? "The state of the lab is unknown: the connection is lost." : "Asking the lab…"}</p>
        </section>
      )}
      {lab?.members.length === 0 && (
        <section class="panel">
          <div class="empty big">
            <p>
              <strong>No lab.</strong>
            </p>
            <p>
              Start <code>seoro ui --connect ENDPOINT</code> with the endpoint of simulators, bridges or executors to see their robots.
            </p>
          </div>
        </section>
      )}
      {lab?.members.map((member) => (
        <Member key={`${member.endpoint}\n${member.name}`} member={member} onWish={shared.site.mayAct ? setWish : null} />
      ))}
      {wish && <WishDialog wish={wish} onClose={() => setWish(null)} />}
    </>
  );
}

function Member({ member, onWish }: { member: LabMember; onWish: ((wish: Wish) => void) | null }) {
  const now = useNow(member.robots.some((robot) => robot.until !== null));
  const isRecorded = member.kind === "bag";
  return (
    <section class="panel member" aria-label={clip(plain(member.name || member.endpoint), 80)}>
      <div class="head">
        <h2>
          <bdi>{clip(plain(member.name || member.endpoint), 120)}</bdi>
        </h2>
        <span class="count">
          {[plain(member.kind), member.name ? clip(plain(member.endpoint), 100) : ""].filter(Boolean).join(", ")}
        </span>
      </div>
      {member.stopped && <p class="stopped-text">{clip(plain(member.stopped), 300)}</p>}
      {member.problem && <Problem error={new Error(plain(member.problem))} />}
      {member.robots.length === 0 ? (
        !member.problem && <p class="empty">{member.kind === "executor" ? "It has no robots of its own." : "No robots."}</p>
      ) : (
        <ul class="robots">
          {member.robots.map((robot) => (
            <Robot key={robot.name} robot={robot} now={now} onWish={isRecorded ? null : onWish} isRecorded={isRecorded} />
          ))}
        </ul>
      )}
    </section>
  );
}

const RECORDED: [sign: string, word: string, style: string] = ["▷", "recorded", "simulated"];
const KINDS = new Map<boolean | null, [sign: string, word: string, style: string]>([
  [true, ["⚠", "REAL", "real"]],
  [false, ["◇", "simulated", "simulated"]],
  [null, ["?", "unknown", "simulated"]],
]);

interface RobotProps {
  robot: LabRobot;
  now: number;
  onWish: ((wish: Wish) => void) | null;
  isRecorded: boolean;
}

function Robot({ robot, now, onWish, isRecorded }: RobotProps) {
  const [sign, word, style] = isRecorded ? RECORDED : KINDS.get(robot.real)!;
  const name = clip(plain(robot.name), 80);
  const button = (kind: Wish["kind"], text: string, label: string) => (
    <button type="button" class={kind === "stop" ? "danger" : ""} aria-label={label} onClick={() => onWish?.({ kind, robot })}>
      {text}
    </button>
  );
  return (
    <li class={`robot ${style}`}>
      <div class="robot-name">
        <span class={`kind ${style}`}>
          <span aria-hidden="true">{sign}</span> {word}
        </span>
        <strong>
          <bdi>{name}</bdi>
        </strong>
        <span class="muted">{clip(plain(robot.type), 60)}</span>
      </div>
      <dl>
        <dt>state</dt>
        <dd class={robot.stopped ? "stopped-text" : ""}>
          {plain(robot.stopped ?? robot.state)}
          {robot.detail && <span class="muted"> {clip(plain(robot.detail), 200)}</span>}
        </dd>
        <dt>holder</dt>
        <dd>
          <bdi>{robot.holder ? clip(plain(robot.holder), 160) : "nobody"}</bdi>
          {robot.until !== null && <span class="muted"> for {rest(Math.max(robot.until - now, 0))} more</span>}
        </dd>
        <dt>queue</dt>
        <dd>{robot.queue.length === 0 ? "empty" : robot.queue.map((who) => clip(plain(who), 80)).join(", ")}</dd>
      </dl>
      {onWish !== null && (
        <div class="actions">
          {button("stop", "■ Stop…", `Stop ${name}`)}
          {robot.stopped !== null
            ? button("release", "Release…", `Release the emergency stop of ${name}`)
            : robot.lease === null
              ? button("lease", "Lease…", `Lease ${name}`)
              : button("end-lease", "End lease…", `End the lease of ${name}`)}
        </div>
      )}
    </li>
  );
}

function WishDialog({ wish, onClose }: { wish: Wish; onClose: () => void }) {
  const [minutes, setMinutes] = useState("10");
  const { kind, robot } = wish;
  const name = clip(plain(robot.name), 80);
  const send = async (path: string, body: object) => failedOutcomes((await post<{ outcomes: Outcome[] }>(`/api/lab/${path}`, body)).outcomes);
  if (kind === "stop") {
    return (
      <Confirm title={`Stop ${name}?`} action="Stop" isDangerous onClose={onClose} onConfirm={() => send("stop", { robots: [robot.name] })}>
        <p>It stops, and its goals end. A run that uses it may send new ones: the emergency stop prevents that.</p>
      </Confirm>
    );
  }
  if (kind === "release") {
    return (
      <Confirm
        title={`Release the emergency stop of ${name}?`}
        action="Release"
        ask="Why is it safe?"
        isDangerous
        onClose={onClose}
        onConfirm={(reason) => send("release", { reason, robots: [robot.name] })}
      >
        <p>It may move again as soon as a run commands it.</p>
      </Confirm>
    );
  }
  if (kind === "end-lease") {
    return (
      <Confirm
        title={`End the lease of ${name}?`}
        action="End the lease"
        isDangerous
        onClose={onClose}
        onConfirm={() => send("end-lease", { lease: robot.lease })}
      >
        <p>
          It is held by <bdi>{clip(plain(robot.holder || "somebody"), 160)}</bdi>. A run that uses the lease loses the robot.
        </p>
      </Confirm>
    );
  }
  const isValid = Number(minutes) > 0 && Number(minutes) <= 24 * 60;
  return (
    <Confirm
      title={`Lease ${name}?`}
      action="Lease"
      ask="Purpose"
      isOptional
      onClose={onClose}
      onConfirm={async (purpose) => {
        if (!isValid) throw new Error("expected minutes from 1 to 1440");
        await post("/api/lab/lease", { robots: [robot.name], seconds: 60 * Number(minutes), purpose });
      }}
    >
      <p>While it is leased, only runs that name the lease can use it.</p>
      <label class="field">
        <span class="name">Minutes</span>
        <input inputMode="decimal" value={minutes} onInput={(event) => setMinutes(event.currentTarget.value)} />
      </label>
    </Confirm>
  );
}
