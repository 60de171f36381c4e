// Passed and failed runs by the values of axes, as bars in tables.
import type { Axis, Bucket } from "../app/types";
import { clip, digits, plain, plural, whole } from "../text";

const CLEAR = 3; // standard deviations beyond chance

export function Outcomes({ title, axes, empty }: { title: string; axes: Axis[]; empty: string }) {
  const sorted = [...axes].sort((a, b) => (b.influence ?? 0) - (a.influence ?? 0));
  return (
    <section class="panel" aria-label={title}>
      <h2>{title}</h2>
      {axes.length === 0 && <p class="empty">{empty}</p>}
      <div class="axes">
        {sorted.map((axis) => (
          <AxisTable key={axis.path} axis={axis} />
        ))}
      </div>
    </section>
  );
}

function AxisTable({ axis }: { axis: Axis }) {
  const most = Math.max(...axis.buckets.map((bucket) => bucket.passed + bucket.failed), 1);
  return (
    <table class="outcome">
      <caption>
        <bdi>{clip(plain(axis.path), 120)}</bdi>
        {(axis.influence ?? 0) >= CLEAR && <span class="muted"> ▲ the outcome depends on it</span>}
      </caption>
      <thead class="hidden">
        <tr>
          <th scope="col">value</th>
          <th scope="col">runs</th>
          <th scope="col">failed</th>
        </tr>
      </thead>
      <tbody>
        {axis.buckets.map((bucket) => (
          <tr key={bucket.label}>
            <th scope="row">
              <bdi>{clip(plain(bucket.label), 40)}</bdi>
            </th>
            <td class="bar-cell">
              <Bar bucket={bucket} most={most} />
            </td>
            <td class="share">{textOf(bucket)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** Length: number of runs. Failed ones are hatched, too, so that colour is not needed. */
function Bar({ bucket: { passed, failed }, most }: { bucket: Bucket; most: number }) {
  return (
    <span class="stack" role="img" aria-label={`${plural(passed + failed, "run")}`}>
      <span class="part passed" style={{ width: `${(100 * passed) / most}%` }} />
      <span class="part failed" style={{ width: `${(100 * failed) / most}%` }} />
    </span>
  );
}

function textOf({ passed, failed, rateLow, rateHigh }: Bucket): string {
  const all = passed + failed;
  if (all === 0) return "no runs";
  const range = rateLow === null || rateHigh === null ? "" : ` (${digits(100 * (1 - rateHigh), 2)} to ${digits(100 * (1 - rateLow), 2)} %)`;
  return `${whole(failed)} of ${whole(all)} failed${failed > 0 ? range : ""}`;
}
