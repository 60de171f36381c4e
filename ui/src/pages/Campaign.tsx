// One campaign: progress, pass rate, outcome by axis, failures, coverage.
import { useEffect, useMemo } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { useTitle } from "../app/hooks";
import { Link, runPath } from "../app/router";
import { StatusBadge } from "../app/Status";
import type { CampaignFailure, CampaignState } from "../app/types";
import { clock, rest, titleOf } from "../app/words";
import { LiveSocket } from "../net/socket";
import { Cell, useCell } from "../state";
import { clip, digits, plain, plural, shortPlace, shown, whole } from "../text";
import { Outcomes } from "./Outcomes";
import { Progress, Tally } from "./Campaigns";

export function Campaign({ id }: { id: string }) {
  const state = useMemo(() => new Cell<CampaignState | null>(null), [id]);
  const path = `/api/campaign/${encodeURIComponent(id)}`;
  const socket = useMemo(() => new LiveSocket(path, (data) => (state.value = JSON.parse(String(data)) as CampaignState)), [id]);
  useEffect(() => () => socket.close(), [socket]);
  const campaign = useCell(state);
  const refusal = useCell(socket.refusal);
  useTitle(campaign ? clip(plain(titleOf(campaign)), 200) : "Campaign");
  return (
    <>
      <div class="run-bar">
        <nav aria-label="Path" class="crumbs">
          <Link href="/campaigns">Campaigns</Link>
        </nav>
        <div class="actions">
          <a class="button" href={`${path}/report`} download>
            Download report
          </a>
        </div>
      </div>
      {refusal !== null && <Problem error={new Error([refusal.error, refusal.help].filter(Boolean).join(": "))} />}
      {campaign === null ? (
        refusal === null && (
          <section class="panel">
            <p class="empty">Reading the campaign…</p>
          </section>
        )
      ) : (
        <Shown campaign={campaign} />
      )}
    </>
  );
}

function Shown({ campaign }: { campaign: CampaignState }) {
  return (
    <>
      <section class="panel" aria-label="Progress">
        <div class="headline">
          <StatusBadge status={campaign.status ?? ""} />
          <h1>
            <bdi title={plain(campaign.title)}>{clip(plain(titleOf(campaign)), 200)}</bdi>
          </h1>
        </div>
        {campaign.problem && <Problem error={new Error(plain(campaign.problem))} />}
        <ul class="facts" aria-label="Facts of the campaign">
          <li>
            <Progress campaign={campaign} />
          </li>
          <li>
            <Tally counts={campaign.counts ?? {}} />
          </li>
          {campaign.pace !== null && <li>{digits(campaign.pace)} runs/s</li>}
          {campaign.left !== null && <li>{rest(campaign.left)} left</li>}
          {campaign.isReading && <li>reading earlier runs…</li>}
          {campaign.simulator && <li>{plain(campaign.simulator)}</li>}
          <li>strategy {plain(campaign.strategy)}</li>
          <li>seed {campaign.seed}</li>
          {campaign.firstStart && <li>since {clock(campaign.firstStart)}</li>}
          {campaign.impossible > 0 && <li>{plural(campaign.impossible, "impossible combination")}</li>}
        </ul>
        {campaign.stop && <p class="notes">{clip(plain(campaign.stop), 300)}</p>}
      </section>
      <section class="panel" aria-label="Pass rate">
        <h2>Pass rate</h2>
        <PassRate rate={campaign.rate} />
      </section>
      <div class="columns">
        <Failures failures={campaign.latest} />
        <Groups groups={campaign.groups} />
      </div>
      <Outcomes title="Outcome by parameter" axes={campaign.axes} empty="The campaign varies no parameters." />
      {campaign.measurements.length > 0 && <Outcomes title="Outcome by measurement" axes={campaign.measurements} empty="" />}
      {campaign.coverage.length > 0 && <CampaignCoverage items={campaign.coverage} />}
    </>
  );
}

function PassRate({ rate }: { rate: CampaignState["rate"] }) {
  if (rate.share === null) return <p class="empty">No run has passed or failed yet.</p>;
  const hasBounds = rate.low !== null && rate.high !== null;
  const percent = (share: number) => `${digits(100 * share, 4)} %`;
  return (
    <div class="rate-line">
      <strong class="big-number">{percent(rate.share)}</strong>
      <div class="range" aria-hidden="true">
        {hasBounds && <span class="interval" style={{ left: `${100 * rate.low!}%`, right: `${100 - 100 * rate.high!}%` }} />}
        <span class="point" style={{ left: `${100 * rate.share}%` }} />
        <span class="end">0 %</span>
        <span class="end right">100 %</span>
      </div>
      <p class="muted">
        {whole(rate.passed)} passed, {whole(rate.failed)} failed.
        {hasBounds && ` Between ${percent(rate.low!)} and ${percent(rate.high!)} (${plain(rate.validity)}).`}
      </p>
    </div>
  );
}

function Failures({ failures }: { failures: CampaignFailure[] }) {
  return (
    <section class="panel" aria-label="Latest failures">
      <h2>Latest failures</h2>
      {failures.length === 0 ? (
        <p class="empty">No run has failed.</p>
      ) : (
        <ul class="failures">
          {failures.map((failure) => (
            <li key={failure.run}>
              <StatusBadge status={failure.status} />{" "}
              {failure.kept === null ? <span>run {failure.run}</span> : <Link href={runPath(failure.kept)}>run {failure.run}</Link>}{" "}
              <span class="muted">seed {failure.seed}</span>
              <div>
                <bdi>{clip(plain(failure.reason), 300)}</bdi>{" "}
                {failure.where && <span class="muted">{clip(plain(shortPlace(failure.where)), 80)}</span>}
              </div>
              <div class="muted values-line">
                {Object.entries(failure.values)
                  .slice(0, 12)
                  .map(([name, value]) => `${clip(plain(name), 60)} = ${clip(plain(shown(value)), 60)}`)
                  .join(", ")}
              </div>
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

function Groups({ groups }: { groups: CampaignState["groups"] }) {
  return (
    <section class="panel" aria-label="Reasons of failures">
      <h2>Reasons</h2>
      {groups.length === 0 ? (
        <p class="empty">No run has failed.</p>
      ) : (
        <div class="scrolls" tabIndex={0} role="region" aria-label="Reasons">
          <table class="full">
            <thead>
              <tr>
                <th scope="col">runs</th>
                <th scope="col">reason</th>
                <th scope="col">place</th>
                <th scope="col">example</th>
              </tr>
            </thead>
            <tbody>
              {groups.map((group) => (
                <tr key={`${group.reason}\n${group.where}`}>
                  <td>{whole(group.count)}</td>
                  <td>
                    <bdi>{clip(plain(group.reason), 300)}</bdi>
                  </td>
                  <td>{clip(plain(shortPlace(group.where)), 80)}</td>
                  <td>run {group.example}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function CampaignCoverage({ items }: { items: CampaignState["coverage"] }) {
  return (
    <section class="panel" aria-label="Coverage">
      <h2>Coverage</h2>
      <ul class="covered">
        {items.map((item) => (
          <li key={item.item}>
            <bdi>{clip(plain(item.item), 160)}</bdi>:{" "}
            {item.reachable === null ? plural(item.reached, "bucket") : `${item.reached} of ${plural(item.reachable, "bucket")}`}
            {item.reachable !== null && (
              <meter min={0} max={Math.max(item.reachable, 1)} value={item.reached} aria-label={`Coverage of ${clip(plain(item.item), 80)}`} />
            )}
            {item.holeCount > 0 && (
              <span class="muted">
                missing: {item.holes.map((hole) => clip(plain(shown(hole)), 60)).join(", ")}
                {item.holeCount > item.holes.length ? `, ${item.holeCount - item.holes.length} more` : ""}
              </span>
            )}
          </li>
        ))}
      </ul>
    </section>
  );
}
