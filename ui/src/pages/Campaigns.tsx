// Campaigns below the folders of the site.
import { Problem } from "../app/Confirm";
import { useAnswer, useNow, useTitle } from "../app/hooks";
import { campaignPath, Link } from "../app/router";
import { StatusBadge } from "../app/Status";
import type { Campaign } from "../app/types";
import { clock, titleOf } from "../app/words";
import { get } from "../net/api";
import { clip, plain, plural, whole } from "../text";

const REFRESH = 3; // [s] between two readings

export function Campaigns() {
  useTitle("Campaigns");
  const now = useNow(true);
  const { data, error } = useAnswer(() => get<{ campaigns: Campaign[] }>("/api/campaigns"), [Math.floor(now / REFRESH)]);
  return (
    <>
      <div class="title">
        <h1>Campaigns</h1>
        <span class="count" role="status">
          {data && plural(data.campaigns.length, "campaign")}
        </span>
      </div>
      {error !== null && <Problem error={error} />}
      {error === null && (
        <section class="panel" aria-label="Campaigns">
          {data === null ? (
            <p class="empty">Reading the campaigns…</p>
          ) : data.campaigns.length === 0 ? (
            <div class="empty big">
              <p>
                <strong>No campaigns.</strong>
              </p>
              <p>
                <code>seoro campaign run FILE -o folder/</code> runs a scenario many times. Its folder appears here if it is below a folder
                that is shown.
              </p>
            </div>
          ) : (
            <ul class="campaigns">
              {data.campaigns.map((campaign) => (
                <Entry key={campaign.id} campaign={campaign} />
              ))}
            </ul>
          )}
        </section>
      )}
    </>
  );
}

function Entry({ campaign }: { campaign: Campaign }) {
  return (
    <li>
      <div>
        <Link href={campaignPath(campaign.id)}>
          <bdi>{clip(plain(titleOf(campaign)), 160)}</bdi>
        </Link>{" "}
        <span class="muted">
          <bdi>{clip(plain(campaign.folder ?? ""), 200)}</bdi>
          {campaign.changed ? `, changed ${clock(campaign.changed)}` : ""}
        </span>
        {campaign.problem && <div class="failed">{clip(plain(campaign.problem), 300)}</div>}
      </div>
      <StatusBadge status={campaign.status ?? "unreadable"} />
      {campaign.status && <Progress campaign={campaign} />}
      {campaign.status && <Tally counts={campaign.counts ?? {}} />}
    </li>
  );
}

export function Progress({ campaign: { done = 0, runs = null, title } }: { campaign: Campaign }) {
  return (
    <span class="progress">
      {runs !== null && <progress max={Math.max(runs, 1)} value={done} aria-label={`Progress of ${clip(plain(title), 60)}`} />}
      {runs === null ? plural(done, "run") : `${whole(done)} of ${plural(runs, "run")}`}
    </span>
  );
}

/** Numbers of runs by their ends. */
export function Tally({ counts }: { counts: { [status: string]: number } }) {
  const found = Object.entries(counts).filter(([, count]) => count > 0);
  if (found.length === 0) return <span class="muted">no run has ended</span>;
  return (
    <span class="tally">
      {found.map(([status, count]) => (
        <span key={status} class={`status ${status}`}>
          {whole(count)} {plain(status).replaceAll("_", " ")}
        </span>
      ))}
    </span>
  );
}
